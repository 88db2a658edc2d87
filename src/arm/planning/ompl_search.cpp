#include "arm/planning/ompl_search.hpp"

#include <map>
#include <memory>
#include <set>
#include <utility>

#include <ompl/base/MotionValidator.h>
#include <ompl/base/PlannerTerminationCondition.h>
#include <ompl/base/objectives/PathLengthOptimizationObjective.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/informedtrees/ABITstar.h>
#include <ompl/geometric/planners/informedtrees/AITstar.h>
#include <ompl/geometric/planners/informedtrees/BITstar.h>
#include <ompl/geometric/planners/kpiece/LBKPIECE1.h>
#include <ompl/geometric/planners/prm/PRMstar.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>

#include "arm/planning/ompl_common.hpp"
#include "arm/planning/states.hpp"

namespace extperfc::arm {

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

ob::SpaceInformationPtr make_space(CollisionChecker& checker, const JointLimits& limits) {
  auto information = std::make_shared<ob::SpaceInformation>(bounded_space(limits));
  const unsigned joints = information->getStateDimension();
  information->setStateValidityChecker(
      [&checker, joints](const ob::State* state) { return checker.is_free(to_joints(state, joints)); });
  information->setMotionValidator(std::make_shared<FreeMotion>(information, checker));
  information->setup();
  return information;
}

}  // namespace

const std::vector<std::string>& ompl_planners() {
  static const std::vector<std::string> names = names_of(makers());
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
  seed_ompl_once(params.seed);
  const auto space = make_space(checker, limits);
  const auto problem = make_problem(space, start, goals, write);
  auto shortest = std::make_shared<ob::PathLengthOptimizationObjective>(space);
  if (!improve) shortest->setCostThreshold(shortest->infiniteCost());  // the first path will do
  problem->setOptimizationObjective(shortest);
  const auto planner = makers().at(params.planner)(space, params.range_rad);
  planner->setProblemDefinition(problem);
  planner->setup();
  if (planner->solve(ob::PlannerTerminationCondition(stop)) != ob::PlannerStatus::EXACT_SOLUTION)
    return std::nullopt;
  auto* path = problem->getSolutionPath()->as<og::PathGeometric>();
  Found found;
  for (const auto* state : path->getStates())
    found.waypoints.push_back(to_joints(state, space->getStateDimension()));
  found.goal = nearest(goals, found.waypoints.back());
  return found;
}

}  // namespace extperfc::arm
