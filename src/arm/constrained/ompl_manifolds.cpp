#include "arm/constrained/ompl_manifolds.hpp"

#include <map>
#include <memory>
#include <utility>

#include <Eigen/Cholesky>
#include <ompl/base/ConstrainedSpaceInformation.h>
#include <ompl/base/Constraint.h>
#include <ompl/base/PlannerTerminationCondition.h>
#include <ompl/base/spaces/constraint/AtlasStateSpace.h>
#include <ompl/base/spaces/constraint/ProjectedStateSpace.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Exception.h>

#include "arm/planning/ompl_common.hpp"
#include "arm/planning/states.hpp"

namespace extperfc::arm {

namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

/// OMPL's projections end here; refinement follows.
constexpr double kProjected = 1e-6;

JointVector to_joints(const ob::State* state) {
  return *state->as<ob::ConstrainedStateSpace::StateType>();
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

// Charts of the atlas have to be anchored at the ends; other spaces have none.
void anchor(const SpacePtr& space, const ob::State* state) {
  if (auto* atlas = dynamic_cast<ob::AtlasStateSpace*>(space.get())) atlas->anchorChart(state);
}

std::optional<Found> proven(Manifold& manifold, og::PathGeometric& path, const JointVector& start,
                            const States& goals, const std::function<bool()>& stop) {
  path.interpolate();
  States coarse;
  for (const auto* state : path.getStates()) coarse.push_back(to_joints(state));
  for (auto& state : coarse)
    if (const auto nearer = manifold.constraint().project(state, manifold.limits())) state = *nearer;
  Found found{{start}, nearest(goals, coarse.back())};
  coarse.back() = goals[static_cast<std::size_t>(found.goal)];
  coarse.erase(coarse.begin());
  if (manifold.prove(start, coarse, &found.waypoints, stop) < coarse.size()) return std::nullopt;
  return found;
}

std::optional<Found> search_once(CollisionChecker& checker, Manifold& manifold,
                                 const ob::ConstraintPtr& constraint, const ConstrainedPlannerParams& params,
                                 const JointVector& start, const States& goals,
                                 const std::function<bool()>& stop) {
  const auto space = makers().at(params.planner)(bounded_space(manifold.limits()), constraint);
  const auto information = std::make_shared<ob::ConstrainedSpaceInformation>(space);
  const auto& limits = manifold.limits();
  information->setStateValidityChecker([&](const ob::State* state) {
    const JointVector joints = to_joints(state);
    return (joints.array() >= limits.lower.array()).all() && (joints.array() <= limits.upper.array()).all() &&
           checker.is_free(joints);
  });
  information->setup();
  const auto problem =
      make_problem(information, start, goals, [&](const JointVector& joints, ob::State* state) {
        state->as<ob::ConstrainedStateSpace::StateType>()->copy(joints);
        anchor(space, state);
      });
  og::RRTConnect planner(information);
  planner.setRange(params.range_rad);
  planner.setProblemDefinition(problem);
  planner.setup();
  if (planner.solve(ob::PlannerTerminationCondition(stop)) != ob::PlannerStatus::EXACT_SOLUTION)
    return std::nullopt;
  return proven(manifold, *problem->getSolutionPath()->as<og::PathGeometric>(), start, goals, stop);
}

}  // namespace

const std::vector<std::string>& ompl_manifold_planners() {
  static const std::vector<std::string> names = names_of(makers());
  return names;
}

std::optional<Found> ompl_search(CollisionChecker& checker, Manifold& manifold,
                                 const ConstrainedPlannerParams& params, const JointVector& start,
                                 const States& goals, const std::function<bool()>& stop) {
  seed_ompl_once(params.seed);
  const auto constraint = std::make_shared<Equations>(manifold.constraint());
  std::optional<Found> found;
  try {
    while (!found && !stop()) found = search_once(checker, manifold, constraint, params, start, goals, stop);
  } catch (const ompl::Exception&) {
    return std::nullopt;  // no chart at an end: a singular Jacobian there
  }
  return found;
}

}  // namespace extperfc::arm
