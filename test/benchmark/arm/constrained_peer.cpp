#include "test/benchmark/arm/constrained_peer.hpp"

#include <memory>
#include <utility>

#include <Eigen/Cholesky>
#include <ompl/base/ConstrainedSpaceInformation.h>
#include <ompl/base/Constraint.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/base/spaces/constraint/AtlasStateSpace.h>
#include <ompl/base/spaces/constraint/ProjectedStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/Exception.h>

#include "extperfc/base/stopwatch.hpp"

namespace extperfc::benchmark {

namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

constexpr double kSimplifyS = 1.0;

class LevelTool : public ob::Constraint {
 public:
  explicit LevelTool(arm::PathConstraint constraint)
      : ob::Constraint(static_cast<unsigned>(constraint.joint_count()),
                       static_cast<unsigned>(constraint.equation_count())),
        constraint_(std::move(constraint)) {}
  void function(const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::Ref<Eigen::VectorXd> out) const override {
    out = constraint_.residual(x);
  }
  void jacobian(const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::Ref<Eigen::MatrixXd> out) const override {
    out = constraint_.jacobian(x);
  }
  /// As OMPL's own, but for the decomposition: the one in its library does not work in programs that have
  /// Eigen's singular values compiled otherwise (an assertion there ends them).
  bool project(Eigen::Ref<Eigen::VectorXd> x) const override {
    Eigen::VectorXd value(getCoDimension());
    Eigen::MatrixXd slope(getCoDimension(), getAmbientDimension());
    for (unsigned i = 0; i <= getMaxIterations(); ++i) {
      function(x, value);
      if (!value.allFinite()) return false;
      if (value.norm() < getTolerance()) return true;
      jacobian(x, slope);
      Eigen::MatrixXd square = slope * slope.transpose();
      square.diagonal().array() += 1e-12;
      x -= slope.transpose() * square.ldlt().solve(value);
    }
    return false;
  }

 private:
  arm::PathConstraint constraint_;
};

arm::JointVector joints_of(const ob::State* state) {
  return *state->as<ob::ConstrainedStateSpace::StateType>();
}

std::shared_ptr<ob::ConstrainedStateSpace> space_of(const LevelProblem& problem, PeerSpace kind) {
  const auto& limits = problem.model.limits();
  const auto joints = static_cast<unsigned>(limits.lower.size());
  auto ambient = std::make_shared<ob::RealVectorStateSpace>(joints);
  ob::RealVectorBounds bounds(joints);
  for (unsigned j = 0; j < joints; ++j) {
    bounds.setLow(j, limits.lower[j]);
    bounds.setHigh(j, limits.upper[j]);
  }
  ambient->setBounds(bounds);
  const auto constraint = std::make_shared<LevelTool>(problem.constraint);
  if (kind == PeerSpace::kAtlas) return std::make_shared<ob::AtlasStateSpace>(ambient, constraint);
  return std::make_shared<ob::ProjectedStateSpace>(ambient, constraint);
}

void solve(og::SimpleSetup& setup, double timeout_s, PeerPlan* plan) {
  plan->solved = setup.solve(timeout_s) == ob::PlannerStatus::EXACT_SOLUTION;
  if (!plan->solved) return;
  setup.simplifySolution(kSimplifyS);
  auto& path = setup.getSolutionPath();
  path.interpolate();
  for (const auto* state : path.getStates()) plan->waypoints.push_back(joints_of(state));
}

}  // namespace

PeerPlan plan_with_ompl(const LevelProblem& problem, arm::CollisionChecker& checker, PeerSpace kind,
                        double timeout_s) {
  ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
  const CpuStopwatch watch;
  PeerPlan plan;
  try {
    const auto space = space_of(problem, kind);
    og::SimpleSetup setup(std::make_shared<ob::ConstrainedSpaceInformation>(space));
    const auto& limits = problem.model.limits();
    setup.setStateValidityChecker([&](const ob::State* state) {
      const arm::JointVector joints = joints_of(state);
      return (joints.array() >= limits.lower.array()).all() &&
             (joints.array() <= limits.upper.array()).all() && checker.is_free(joints);
    });
    ob::ScopedState<> from(space), to(space);
    from->as<ob::ConstrainedStateSpace::StateType>()->copy(problem.start);
    to->as<ob::ConstrainedStateSpace::StateType>()->copy(problem.goal);
    if (auto* atlas = dynamic_cast<ob::AtlasStateSpace*>(space.get())) {
      atlas->anchorChart(from.get());
      atlas->anchorChart(to.get());
    }
    setup.setStartAndGoalStates(from, to);
    setup.setPlanner(std::make_shared<og::RRTConnect>(setup.getSpaceInformation()));
    setup.setup();
    solve(setup, timeout_s, &plan);
  } catch (const ompl::Exception&) {
    plan.solved = false;
  }
  plan.seconds = watch.seconds();
  return plan;
}

}  // namespace extperfc::benchmark
