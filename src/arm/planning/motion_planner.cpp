#include "extperfc/arm/motion_planner.hpp"

#include <optional>
#include <utility>

#include "arm/planning/ompl_search.hpp"
#include "arm/planning/search.hpp"
#include "arm/planning/search_and_shorten.hpp"
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
    const auto& others = ompl_planners();
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
    : checker_(checker), params_(params), limits_(bounded(checker.model().limits())) {
  demand_planner(params.planner, planner_names());
  demand_ranges(params);
}

PlanResult MotionPlanner::plan(const PlanRequest& request) {
  Checked checked;
  if (auto refusal = check_request(checker_, limits_, params_.limit_repair_rad, request, checked))
    return *refusal;
  const auto search = [&](const Stop& stop, int* states) -> std::optional<Found> {
    if (params_.planner != kOwnPlanner)
      return ompl_search(checker_, limits_, params_, checked.start, checked.goals, false, stop);
    Search own(checker_, limits_, params_);
    auto found = own.run(checked.start, checked.goals, stop);
    *states = own.states();
    return found;
  };
  const auto shortening = [&](std::vector<JointVector> waypoints, Rng& rng, const Stop& stop) {
    return shorten(checker_, std::move(waypoints), params_.shortcut_rounds, rng, stop);
  };
  return search_and_shorten(request, checked, params_, search, shortening);
}

}  // namespace extperfc::arm
