#include "extperfc/arm/motion_planner.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "extperfc/base/stopwatch.hpp"

#include "arm/planning/ompl_search.hpp"
#include "arm/planning/request_validator.hpp"
#include "arm/planning/search.hpp"
#include "arm/planning/shortcuts.hpp"

namespace extperfc::arm {

namespace {

constexpr const char* kOwnPlanner = "rrt_connect";

}  // namespace

const char* to_string(PlanCode code) {
  switch (code) {
    case PlanCode::kSuccess:
      return "success";
    case PlanCode::kInvalidRequest:
      return "invalid_request";
    case PlanCode::kStartOutsideLimits:
      return "start_outside_limits";
    case PlanCode::kStartInCollision:
      return "start_in_collision";
    case PlanCode::kGoalOutsideLimits:
      return "goal_outside_limits";
    case PlanCode::kGoalInCollision:
      return "goal_in_collision";
    case PlanCode::kTimeout:
      return "timeout";
    case PlanCode::kCancelled:
      return "cancelled";
  }
  return "unknown";
}

const std::vector<std::string>& planner_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result{kOwnPlanner};
    const auto& others = planning::ompl_planners();
    result.insert(result.end(), others.begin(), others.end());
    return result;
  }();
  return names;
}

double path_length(const std::vector<JointVector>& waypoints) {
  double length = 0;
  for (std::size_t i = 1; i < waypoints.size(); ++i) length += (waypoints[i] - waypoints[i - 1]).norm();
  return length;
}

MotionPlanner::MotionPlanner(CollisionChecker& checker, const PlannerParams& params)
    : checker_(checker), params_(params), limits_(planning::bounded(checker.model().limits())) {
  const auto& names = planner_names();
  if (std::find(names.begin(), names.end(), params.planner) == names.end())
    throw std::invalid_argument("PlannerParams::planner: '" + params.planner +
                                "' is not one of planner_names()");
  planning::demand_ranges(params);
}

std::optional<planning::Found> MotionPlanner::search(const JointVector& start,
                                                     const std::vector<JointVector>& goals,
                                                     const std::function<bool()>& stop, int* states) {
  if (params_.planner != kOwnPlanner)
    return planning::ompl_search(checker_, limits_, params_, start, goals, false, stop);
  planning::Search own(checker_, limits_, params_);
  auto found = own.run(start, goals, stop);
  *states = own.states();
  return found;
}

PlanResult MotionPlanner::plan(const PlanRequest& request) {
  planning::Checked checked;
  if (auto refusal = planning::check_request(checker_, limits_, params_, request, checked)) return *refusal;

  bool cancelled = false;
  const Stopwatch watch;
  const auto asked_to_stop = [&] {
    return cancelled = cancelled || (request.cancelled && request.cancelled());
  };
  const auto stop = [&] { return asked_to_stop() || watch.seconds() > params_.timeout_s; };
  PlanResult result;
  auto found = search(checked.start, checked.goals, stop, &result.states);
  result.search_s = watch.seconds();
  if (!found) {
    result.code = cancelled ? PlanCode::kCancelled : PlanCode::kTimeout;
    result.message = cancelled ? "cancelled"
                               : "no path within " + std::to_string(params_.timeout_s) + " s and " +
                                     std::to_string(params_.max_states) + " states";
    return result;
  }
  Rng rng(params_.seed);
  result.waypoints =
      planning::shorten(checker_, std::move(found->waypoints), params_.shortcut_rounds, rng, asked_to_stop);
  result.shortcut_s = watch.seconds() - result.search_s;
  if (cancelled) return planning::failed(PlanCode::kCancelled, "cancelled");
  result.code = PlanCode::kSuccess;
  result.goal = checked.goal_indices[found->goal];
  result.length_rad = path_length(result.waypoints);
  return result;
}

}  // namespace extperfc::arm
