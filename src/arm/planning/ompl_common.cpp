#include "arm/planning/ompl_common.hpp"

#include <mutex>

#include <ompl/base/ScopedState.h>
#include <ompl/base/goals/GoalStates.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

namespace extperfc::arm {

namespace ob = ompl::base;

void seed_ompl_once(std::uint64_t seed) {
  static std::once_flag once;
  std::call_once(once, [seed] {
    // What concerns the user is in the plan's message.
    ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
    ompl::RNG::setSeed(static_cast<std::uint_fast32_t>(seed));
  });
}

std::shared_ptr<ob::RealVectorStateSpace> bounded_space(const JointLimits& limits) {
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

ob::ProblemDefinitionPtr make_problem(const ob::SpaceInformationPtr& space, const JointVector& start,
                                      const std::vector<JointVector>& goals,
                                      const std::function<void(const JointVector&, ob::State*)>& write) {
  auto problem = std::make_shared<ob::ProblemDefinition>(space);
  ob::ScopedState<> state(space->getStateSpace());
  write(start, state.get());
  problem->addStartState(state);
  auto all_goals = std::make_shared<ob::GoalStates>(space);
  for (const auto& goal : goals) {
    write(goal, state.get());
    all_goals->addState(state);
  }
  problem->setGoal(all_goals);
  return problem;
}

}  // namespace extperfc::arm
