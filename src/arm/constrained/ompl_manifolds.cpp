#include "arm/constrained/ompl_manifolds.hpp"

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include <Eigen/Cholesky>
#include <ompl/base/ConstrainedSpaceInformation.h>
#include <ompl/base/Constraint.h>
#include <ompl/base/PlannerTerminationCondition.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/goals/GoalStates.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/base/spaces/constraint/AtlasStateSpace.h>
#include <ompl/base/spaces/constraint/ProjectedStateSpace.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/Exception.h>
#include <ompl/util/RandomNumbers.h>

namespace extperfc::arm::constrained {

namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

/// OMPL's projections end here; refinement follows.
constexpr double kProjected = 1e-6;

JointVector to_joints(const ob::State* state) {
  return *state->as<ob::ConstrainedStateSpace::StateType>();
}

void write(const JointVector& joints, ob::State* state) {
  state->as<ob::ConstrainedStateSpace::StateType>()->copy(joints);
}

class Equations : public ob::Constraint {
 public:
  explicit Equations(PathConstraint constraint)
      : ob::Constraint(static_cast<unsigned>(constraint.joint_count()),
                       static_cast<unsigned>(constraint.equation_count()), kProjected),
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
  PathConstraint constraint_;
};

class FreeState : public ob::StateValidityChecker {
 public:
  FreeState(const ob::SpaceInformationPtr& space, CollisionChecker& checker, JointLimits limits)
      : ob::StateValidityChecker(space), checker_(checker), limits_(std::move(limits)) {}
  bool isValid(const ob::State* state) const override {
    const JointVector joints = to_joints(state);
    return (joints.array() >= limits_.lower.array()).all() &&
           (joints.array() <= limits_.upper.array()).all() && checker_.is_free(joints);
  }

 private:
  CollisionChecker& checker_;
  JointLimits limits_;
};

using SpacePtr = std::shared_ptr<ob::ConstrainedStateSpace>;
using Maker = SpacePtr (*)(const ob::StateSpacePtr&, const ob::ConstraintPtr&);

template <typename Space>
SpacePtr make(const ob::StateSpacePtr& ambient, const ob::ConstraintPtr& constraint) {
  return std::make_shared<Space>(ambient, constraint);
}

const std::map<std::string, Maker>& makers() {
  static const std::map<std::string, Maker> all{{"atlas_rrt", make<ob::AtlasStateSpace>},
                                                {"projected_rrt", make<ob::ProjectedStateSpace>}};
  return all;
}

void seed_once(std::uint64_t seed) {
  static std::once_flag once;
  std::call_once(once, [seed] {
    ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
    ompl::RNG::setSeed(static_cast<std::uint_fast32_t>(seed));
  });
}

ob::StateSpacePtr ambient_space(const JointLimits& limits) {
  const auto joints = static_cast<unsigned>(limits.lower.size());
  auto space = std::make_shared<ob::RealVectorStateSpace>(joints);
  ob::RealVectorBounds bounds(joints);
  for (unsigned j = 0; j < joints; ++j) {
    bounds.setLow(j, limits.lower[j]);
    bounds.setHigh(j, limits.upper[j]);
  }
  space->setBounds(bounds);
  return space;
}

// Charts of the atlas have to be anchored at the ends; other spaces have none.
void anchor(const SpacePtr& space, const ob::State* state) {
  if (auto* atlas = dynamic_cast<ob::AtlasStateSpace*>(space.get())) atlas->anchorChart(state);
}

ob::ProblemDefinitionPtr make_problem(const ob::SpaceInformationPtr& information, const SpacePtr& space,
                                      const JointVector& start, const States& goals) {
  auto problem = std::make_shared<ob::ProblemDefinition>(information);
  ob::ScopedState<> state(space);
  write(start, state.get());
  anchor(space, state.get());
  problem->addStartState(state);
  auto all_goals = std::make_shared<ob::GoalStates>(information);
  for (const auto& goal : goals) {
    write(goal, state.get());
    anchor(space, state.get());
    all_goals->addState(state);
  }
  problem->setGoal(all_goals);
  return problem;
}

int nearest_goal(const JointVector& end, const States& goals) {
  int nearest = -1;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t g = 0; g < goals.size(); ++g) {
    const double distance = (goals[g] - end).norm();
    if (distance >= smallest) continue;
    smallest = distance;
    nearest = static_cast<int>(g);
  }
  return nearest;
}

std::optional<Found> proven(Manifold& manifold, og::PathGeometric& path, const JointVector& start,
                            const States& goals, const std::function<bool()>& stop) {
  path.interpolate();
  States coarse;
  for (const auto* state : path.getStates()) coarse.push_back(to_joints(state));
  for (auto& state : coarse)
    if (const auto nearer = manifold.constraint().project(state, manifold.limits())) state = *nearer;
  Found found{{start}, nearest_goal(coarse.back(), goals)};
  coarse.back() = goals[static_cast<std::size_t>(found.goal)];
  coarse.erase(coarse.begin());
  if (manifold.prove(start, coarse, &found.waypoints, stop) < coarse.size()) return std::nullopt;
  return found;
}

std::optional<Found> search_once(CollisionChecker& checker, Manifold& manifold,
                                 const ob::ConstraintPtr& constraint, const ConstrainedPlannerParams& params,
                                 const JointVector& start, const States& goals,
                                 const std::function<bool()>& stop) {
  const auto space = makers().at(params.planner)(ambient_space(manifold.limits()), constraint);
  const auto information = std::make_shared<ob::ConstrainedSpaceInformation>(space);
  information->setStateValidityChecker(std::make_shared<FreeState>(information, checker, manifold.limits()));
  information->setup();
  const auto problem = make_problem(information, space, start, goals);
  og::RRTConnect planner(information);
  planner.setRange(params.range_rad);
  planner.setProblemDefinition(problem);
  planner.setup();
  if (planner.solve(ob::PlannerTerminationCondition(stop)) != ob::PlannerStatus::EXACT_SOLUTION)
    return std::nullopt;
  return proven(manifold, *problem->getSolutionPath()->as<og::PathGeometric>(), start, goals, stop);
}

}  // namespace

const std::vector<std::string>& ompl_planners() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result;
    for (const auto& [name, maker] : makers()) result.push_back(name);
    return result;
  }();
  return names;
}

std::optional<Found> ompl_search(CollisionChecker& checker, Manifold& manifold,
                                 const ConstrainedPlannerParams& params, const JointVector& start,
                                 const States& goals, const std::function<bool()>& stop) {
  seed_once(params.seed);
  const auto constraint = std::make_shared<Equations>(manifold.constraint());
  std::optional<Found> found;
  try {
    while (!found && !stop()) found = search_once(checker, manifold, constraint, params, start, goals, stop);
  } catch (const ompl::Exception&) {
    return std::nullopt;  // no chart at an end: a singular Jacobian there
  }
  return found;
}

}  // namespace extperfc::arm::constrained
