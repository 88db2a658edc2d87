#include "test/benchmark/arm/peer_ompl.hpp"

#include <memory>

#include <ompl/base/PlannerTerminationCondition.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

#include "extperfc/base/stopwatch.hpp"

namespace extperfc::benchmark {

namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

constexpr double kResolutionRad = 1.0 / 64.0;

using Space = ob::RealVectorStateSpace;

arm::JointVector to_joints(const ob::State* state, Eigen::Index joints) {
  return Eigen::Map<const Eigen::VectorXd>(state->as<Space::StateType>()->values, joints);
}

std::shared_ptr<Space> space_of(const arm::JointLimits& limits) {
  const auto joints = static_cast<unsigned>(limits.lower.size());
  auto space = std::make_shared<Space>(joints);
  ob::RealVectorBounds bounds(joints);
  for (unsigned j = 0; j < joints; ++j) {
    bounds.setLow(j, limits.lower[j]);
    bounds.setHigh(j, limits.upper[j]);
  }
  space->setBounds(bounds);
  return space;
}

}  // namespace

PeerPlan plan_with_ompl(arm::CollisionChecker& checker, const arm::JointVector& start,
                        const arm::JointVector& goal, double timeout_s) {
  ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
  const Stopwatch watch;
  auto space = space_of(checker.model().limits());
  og::SimpleSetup setup(space);
  const Eigen::Index joints = start.size();
  setup.setStateValidityChecker(
      [&checker, joints](const ob::State* state) { return !checker.contact(to_joints(state, joints)); });
  setup.getSpaceInformation()->setStateValidityCheckingResolution(kResolutionRad / space->getMaximumExtent());
  ob::ScopedState<> from(space);
  ob::ScopedState<> to(space);
  for (Eigen::Index j = 0; j < joints; ++j) {
    from[static_cast<unsigned>(j)] = start[j];
    to[static_cast<unsigned>(j)] = goal[j];
  }
  setup.setStartAndGoalStates(from, to);
  setup.setPlanner(std::make_shared<og::RRTConnect>(setup.getSpaceInformation()));
  PeerPlan plan;
  plan.solved = setup.solve(timeout_s) == ob::PlannerStatus::EXACT_SOLUTION;
  if (plan.solved) setup.simplifySolution();
  plan.seconds = watch.seconds();
  if (!plan.solved) return plan;
  for (const auto* state : setup.getSolutionPath().getStates())
    plan.waypoints.push_back(to_joints(state, joints));
  return plan;
}

}  // namespace extperfc::benchmark
