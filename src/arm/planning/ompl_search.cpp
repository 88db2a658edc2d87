#include "arm/planning/ompl_search.hpp"

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <utility>

#include <ompl/base/MotionValidator.h>
#include <ompl/base/PlannerTerminationCondition.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/goals/GoalStates.h>
#include <ompl/base/objectives/PathLengthOptimizationObjective.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/informedtrees/ABITstar.h>
#include <ompl/geometric/planners/informedtrees/AITstar.h>
#include <ompl/geometric/planners/informedtrees/BITstar.h>
#include <ompl/geometric/planners/kpiece/LBKPIECE1.h>
#include <ompl/geometric/planners/prm/PRMstar.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

namespace extperfc::arm::planning {

namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

using Space = ob::RealVectorStateSpace;

JointVector to_joints(const ob::State* state, unsigned joints) {
  return Eigen::Map<const Eigen::VectorXd>(state->as<Space::StateType>()->values, joints);
}

void write(const JointVector& joints, ob::State* state) {
  Eigen::Map<Eigen::VectorXd>(state->as<Space::StateType>()->values, joints.size()) = joints;
}

class FreeState : public ob::StateValidityChecker {
 public:
  FreeState(const ob::SpaceInformationPtr& space, CollisionChecker& checker)
      : ob::StateValidityChecker(space), checker_(checker), joints_(space->getStateDimension()) {}
  bool isValid(const ob::State* state) const override { return checker_.is_free(to_joints(state, joints_)); }

 private:
  CollisionChecker& checker_;
  unsigned joints_;
};

class FreeMotion : public ob::MotionValidator {
 public:
  FreeMotion(const ob::SpaceInformationPtr& space, CollisionChecker& checker)
      : ob::MotionValidator(space), checker_(checker), joints_(space->getStateDimension()) {}

  bool checkMotion(const ob::State* from, const ob::State* to) const override {
    return checker_.motion_free(to_joints(from, joints_), to_joints(to, joints_));
  }
  // The longest part that is proven free; OMPL wants the last valid state and its fraction.
  bool checkMotion(const ob::State* from, const ob::State* to,
                   std::pair<ob::State*, double>& last_valid) const override {
    const JointVector a = to_joints(from, joints_);
    const JointVector b = to_joints(to, joints_);
    const double fraction = checker_.free_fraction(a, b);
    if (fraction >= 1.0) return true;
    last_valid.second = fraction < 0.0 ? 0.0 : fraction;
    if (last_valid.first != nullptr) write(a + last_valid.second * (b - a), last_valid.first);
    return false;
  }

 private:
  CollisionChecker& checker_;
  unsigned joints_;
};

template <typename Planner>
ob::PlannerPtr make(const ob::SpaceInformationPtr& space, double range_rad) {
  auto planner = std::make_shared<Planner>(space);
  if (planner->params().hasParam("range")) planner->params().setParam("range", std::to_string(range_rad));
  return planner;
}

using Maker = ob::PlannerPtr (*)(const ob::SpaceInformationPtr&, double);

const std::map<std::string, Maker>& makers() {
  static const std::map<std::string, Maker> all{
      {"abit_star", make<og::ABITstar>}, {"ait_star", make<og::AITstar>},
      {"bit_star", make<og::BITstar>},   {"lbkpiece", make<og::LBKPIECE1>},
      {"prm_star", make<og::PRMstar>},   {"ompl_rrt_connect", make<og::RRTConnect>}};
  return all;
}

void seed_once(std::uint64_t seed) {
  static std::once_flag once;
  std::call_once(once, [seed] {
    ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
    ompl::RNG::setSeed(static_cast<std::uint_fast32_t>(seed));
  });
}

ob::SpaceInformationPtr make_space(CollisionChecker& checker, const JointLimits& limits) {
  const auto joints = static_cast<unsigned>(limits.lower.size());
  auto space = std::make_shared<Space>(joints);
  ob::RealVectorBounds bounds(joints);
  for (unsigned j = 0; j < joints; ++j) {
    bounds.setLow(j, limits.lower[j]);
    bounds.setHigh(j, limits.upper[j]);
  }
  space->setBounds(bounds);
  auto information = std::make_shared<ob::SpaceInformation>(space);
  information->setStateValidityChecker(std::make_shared<FreeState>(information, checker));
  information->setMotionValidator(std::make_shared<FreeMotion>(information, checker));
  information->setup();
  return information;
}

ob::ProblemDefinitionPtr make_problem(const ob::SpaceInformationPtr& space, const JointVector& start,
                                      const std::vector<JointVector>& goals, bool improve) {
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
  auto shortest = std::make_shared<ob::PathLengthOptimizationObjective>(space);
  if (!improve) shortest->setCostThreshold(shortest->infiniteCost());  // the first path will do
  problem->setOptimizationObjective(shortest);
  return problem;
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

bool improves(const std::string& ompl_planner) {
  static const std::set<std::string> names{"abit_star", "ait_star", "bit_star", "prm_star"};
  return names.count(ompl_planner) > 0;
}

std::optional<Found> ompl_search(CollisionChecker& checker, const JointLimits& limits,
                                 const PlannerParams& params, const JointVector& start,
                                 const std::vector<JointVector>& goals, bool improve,
                                 const std::function<bool()>& stop) {
  seed_once(params.seed);
  const auto space = make_space(checker, limits);
  const auto problem = make_problem(space, start, goals, improve);
  const auto planner = makers().at(params.planner)(space, params.range_rad);
  planner->setProblemDefinition(problem);
  planner->setup();
  if (planner->solve(ob::PlannerTerminationCondition(stop)) != ob::PlannerStatus::EXACT_SOLUTION)
    return std::nullopt;
  auto* path = problem->getSolutionPath()->as<og::PathGeometric>();
  Found found;
  for (const auto* state : path->getStates())
    found.waypoints.push_back(to_joints(state, space->getStateDimension()));
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t g = 0; g < goals.size(); ++g) {
    const double distance = (goals[g] - found.waypoints.back()).norm();
    if (distance >= smallest) continue;
    smallest = distance;
    found.goal = static_cast<int>(g);
  }
  return found;
}

}  // namespace extperfc::arm::planning
