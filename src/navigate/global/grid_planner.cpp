#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "extperfc/base/demand.hpp"
#include "extperfc/navigate/global_planner.hpp"

#include "navigate/global/footprint_refiner.hpp"
#include "navigate/global/free_pose.hpp"
#include "navigate/global/grid_search.hpp"
#include "navigate/global/path_shape.hpp"
#include "navigate/global/plan_clock.hpp"

namespace extperfc::navigate {

namespace {

constexpr int kMaxPassages = 60;        // closed one after the other before the planner gives up
constexpr int kMaxGoals = 8;            // free poses about a blocked goal that are tried
constexpr double kSpacing_m = 0.08;     // of the points that are smoothed
constexpr double kUnknownAs = 100;      // the cost of an unknown cell that is admitted
constexpr double kBeside_cells = 0.75;  // half a cell's diagonal, and the rounding of its cost
constexpr double kOpened_cells = 2.5;   // inscribed cells that a base may leave or enter at the ends

void validate(const GridPlannerParams& params) {
  const auto within = [](double value, double low, double high) { return value >= low && value <= high; };
  demand(params.neutral_cost > 0 && params.neutral_cost <= 252, "neutral_cost must be in (0, 252]");
  demand(within(params.cost_factor, 0, 100), "cost_factor must be in [0, 100]");
  demand(within(params.default_tolerance_m, 0, 10), "default_tolerance must be in [0, 10] m");
  demand(params.max_time_s > 0 && params.max_time_s <= 600, "max_time must be in (0, 600] s");
  demand(within(params.heading_weight, 0, 1), "heading_weight must be in [0, 1]");
}

/// `narrow`: a passage that was found too narrow meanwhile.
tl::unexpected<NavError> interrupted(const PlanClock& clock, const GridPlannerParams& params,
                                     const std::optional<Pose2>& narrow = std::nullopt) {
  if (clock.ended() == NavCode::kCancelled) return nav_fail(NavCode::kCancelled, "planning was cancelled");
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(), "no path within %g s: raise max_time or plan to a nearer goal",
                params.max_time_s);
  std::string message = text.data();
  if (narrow) message += "; the footprint does not pass near " + place_text(*narrow);
  return nav_fail(NavCode::kPlanTimeout, message, narrow);
}

class GridPlanner : public GlobalPlanner {
 public:
  explicit GridPlanner(const GridPlannerParams& params) : params_(params) { validate(params); }

  NavResult<Path> plan(const CostGrid& costs, const Footprint& footprint,
                       const PlanRequest& request) override;

 private:
  /// What one call plans with.
  struct Call {
    const CostGrid& costs;
    const Footprint& footprint;
    const PlanRequest& request;
    PlanClock clock;
    Traversal traversal;
    FootprintRefiner refiner;

    Call(const GridPlanner& planner, const CostGrid& grid, const Footprint& outline,
         const PlanRequest& wanted)
        : costs(grid),
          footprint(outline),
          request(wanted),
          clock(wanted.cancel, planner.params_.max_time_s),
          traversal(planner.traversal(grid, outline)),
          refiner(grid, outline, traversal, planner.params_.base, clock) {}
    [[nodiscard]] Eigen::Vector2d in_cells(const Pose2& pose) const {
      return (Eigen::Vector2d(pose.x, pose.y) - costs.origin_m) / costs.resolution_m;
    }
    [[nodiscard]] Pose2 in_metres(const Eigen::Vector2d& point) const {
      const Eigen::Vector2d at = costs.origin_m + costs.resolution_m * point;
      return {at.x(), at.y(), 0};
    }
  };

  [[nodiscard]] Traversal traversal(const CostGrid& costs, const Footprint& footprint) const;
  [[nodiscard]] static std::optional<NavError> wrong_request(const CostGrid& costs,
                                                             const PlanRequest& request);
  [[nodiscard]] std::optional<NavError> blocked_start(const Call& call) const;
  /// The goal itself, or free poses about it.
  [[nodiscard]] NavResult<std::vector<Pose2>> goals(const Call& call) const;
  [[nodiscard]] NavResult<Path> plan_to(Call& call, const Pose2& goal);
  static void close(Call& call, const Eigen::Vector2d& place_cells);
  [[nodiscard]] Path make_path(const Call& call, const std::vector<Pose2>& poses) const;
  [[nodiscard]] NavError unreachable(const Call& call, const Pose2& goal);
  [[nodiscard]] NavError too_narrow(const Call& call, const Pose2& where) const;

  GridPlannerParams params_;
  GridSearch search_;
};

Traversal GridPlanner::traversal(const CostGrid& costs, const Footprint& footprint) const {
  Traversal traversal;
  const auto weight = [&](double cost) {
    return static_cast<float>(1 + params_.cost_factor * cost / params_.neutral_cost);
  };
  for (std::size_t cost = 0; cost < kInscribedCost; ++cost)
    traversal.weight[cost] = weight(static_cast<double>(cost));
  // Beside inscribed cells the outline may touch although the middle of the cell is far enough away.
  const Inflation& inflation = costs.inflation;
  const double beside_m = footprint.inscribed_radius_m() + kBeside_cells * costs.resolution_m;
  if (inflation.radius_m > beside_m)
    for (std::size_t cost = std::max<Cost>(1, inflation.cost_at(beside_m)); cost < kInscribedCost; ++cost)
      traversal.weight[cost] += 1;
  if (params_.allow_unknown) traversal.weight[kUnknownCost] = weight(kUnknownAs);
  traversal.inscribed_cells = footprint.inscribed_radius_m() / costs.resolution_m;
  return traversal;
}

std::optional<NavError> GridPlanner::wrong_request(const CostGrid& costs, const PlanRequest& request) {
  if (!is_finite(request.start) || !is_finite(request.goal))
    return NavError{NavCode::kInvalidRequest, "start and goal must be finite"};
  if (!std::isfinite(request.tolerance_m) || request.tolerance_m < 0)
    return NavError{NavCode::kInvalidRequest, "tolerance must be finite and at least 0 m"};
  if (costs.empty()) return NavError{NavCode::kStartOutside, "the map has no cells", request.start};
  const auto outside = [&](const Pose2& pose) { return !costs.cell_of({pose.x, pose.y}); };
  if (outside(request.start))
    return NavError{
        NavCode::kStartOutside,
        "start " + place_text(request.start) + " is outside the map: localize the robot in this map",
        request.start};
  if (outside(request.goal))
    return NavError{NavCode::kGoalOutside,
                    "goal " + place_text(request.goal) + " is outside the map: choose a goal inside",
                    request.goal};
  return std::nullopt;
}

std::optional<NavError> GridPlanner::blocked_start(const Call& call) const {
  const Pose2& start = call.request.start;
  if (call.refiner.is_free(start)) return std::nullopt;
  const bool obstacle = contact(call.costs, call.footprint, start) == Contact::kObstacle;
  return NavError{NavCode::kStartBlocked,
                  std::string("the footprint at the start ") + place_text(start) + " touches " +
                      (obstacle ? "an obstacle: clear the cost map or move the robot away from it"
                                : "unknown space: allow unknown space or map it first"),
                  start};
}

NavResult<std::vector<Pose2>> GridPlanner::goals(const Call& call) const {
  const Pose2& goal = call.request.goal;
  if (call.refiner.is_free(goal)) return std::vector<Pose2>{goal};
  const double tolerance_m =
      call.request.tolerance_m > 0 ? call.request.tolerance_m : params_.default_tolerance_m;
  auto near = free_poses(call.costs, call.refiner, goal, tolerance_m, kMaxGoals, call.clock);
  if (call.clock.ended()) return interrupted(call.clock, params_);
  if (!near.empty()) return near;
  const bool obstacle = contact(call.costs, call.footprint, goal) == Contact::kObstacle;
  return nav_fail(obstacle ? NavCode::kGoalBlocked : NavCode::kGoalUnknown,
                  std::string("the footprint at the goal ") + place_text(goal) + " touches " +
                      (obstacle ? "an obstacle" : "unknown space") +
                      (tolerance_m > 0 ? ", and so it does all about it" : "") +
                      ": choose a free goal or a larger tolerance",
                  goal);
}

NavResult<Path> GridPlanner::plan(const CostGrid& costs, const Footprint& footprint,
                                  const PlanRequest& request) {
  if (auto error = wrong_request(costs, request)) return tl::unexpected<NavError>(std::move(*error));
  Call call(*this, costs, footprint, request);
  if (call.clock.ended()) return interrupted(call.clock, params_);
  if (auto error = blocked_start(call)) return tl::unexpected<NavError>(std::move(*error));
  const auto candidates = goals(call);
  if (!candidates) return tl::unexpected<NavError>(candidates.error());
  std::optional<NavError> first_error;
  for (const Pose2& goal : *candidates) {
    auto path = plan_to(call, goal);
    if (path || path.error().code != NavCode::kNoPath) return path;
    if (!first_error) first_error = std::move(path.error());
  }
  return tl::unexpected<NavError>(std::move(*first_error));
}

NavResult<Path> GridPlanner::plan_to(Call& call, const Pose2& goal) {
  const Eigen::Vector2d from = call.in_cells(call.request.start);
  const Eigen::Vector2d to = call.in_cells(goal);
  call.traversal.opened = {{from, kOpened_cells}, {to, kOpened_cells}};
  call.traversal.closed.clear();
  std::optional<Pose2> narrow;
  for (int passages = 0; passages < kMaxPassages; ++passages) {
    const GridSearch::Status status = search_.find(call.costs, call.traversal, from, to, call.clock);
    if (status == GridSearch::Status::kInterrupted) return interrupted(call.clock, params_, narrow);
    if (status == GridSearch::Status::kNoPath)
      return tl::unexpected<NavError>(narrow ? too_narrow(call, *narrow) : unreachable(call, goal));
    CellSpace& cells = search_.cells();
    const Polyline line = smooth(cells, pull(cells, search_.path()), kSpacing_m / call.costs.resolution_m);
    std::vector<Eigen::Vector2d> points_m;
    points_m.reserve(line.size());
    for (const auto& point : line)
      points_m.emplace_back(call.costs.origin_m + call.costs.resolution_m * point);
    auto refined = call.refiner.refine(add_headings(points_m, call.request.start, goal, params_));
    if (refined.status == FootprintRefiner::Status::kInterrupted)
      return interrupted(call.clock, params_, narrow);
    if (refined.status == FootprintRefiner::Status::kFree) return make_path(call, refined.poses);
    if (!narrow) narrow = refined.where;
    close(call, call.in_cells(*refined.where));
  }
  return tl::unexpected<NavError>(too_narrow(call, *narrow));
}

/// A disc about the place; the more discs lie there already, the larger: the passage is wider than they are.
void GridPlanner::close(Call& call, const Eigen::Vector2d& place_cells) {
  const double near_cells = std::max(10.0, 2 * call.traversal.inscribed_cells);
  const auto before =
      std::count_if(call.traversal.closed.begin(), call.traversal.closed.end(),
                    [&](const Disc& disc) { return (disc.middle - place_cells).norm() < near_cells; });
  const double radius = std::max(3.0, 0.5 * call.traversal.inscribed_cells);
  call.traversal.closed.push_back({place_cells, std::min(1.0 + static_cast<double>(before), 4.0) * radius});
}

Path GridPlanner::make_path(const Call& call, const std::vector<Pose2>& poses) const {
  Path path{poses, 0};
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const auto cell = call.costs.cell_of({poses[i].x, poses[i].y});
    const float weight = cell ? call.traversal.weight[call.costs.at(*cell)] : 0.0F;
    path.cost += std::hypot(poses[i].x - poses[i - 1].x, poses[i].y - poses[i - 1].y) *
                 static_cast<double>(weight > 0 ? weight : call.traversal.weight[kInscribedCost - 1]);
  }
  return path;
}

NavError GridPlanner::too_narrow(const Call& call, const Pose2& where) const {
  return {NavCode::kNoPath,
          "no path from " + place_text(call.request.start) + " to " + place_text(call.request.goal) +
              ": the footprint does not pass near " + place_text(where) +
              "; clear that passage or choose another goal",
          where};
}

/// Where a path of minimal cost through obstacles first meets one.
NavError GridPlanner::unreachable(const Call& call, const Pose2& goal) {
  NavError error{NavCode::kNoPath,
                 "no path from " + place_text(call.request.start) + " to " + place_text(goal) +
                     ": they are not connected",
                 goal};
  CellSpace cells;
  cells.begin(call.costs, call.traversal);
  Traversal through = call.traversal;
  through.inscribed_cells = 0;
  for (std::size_t cost = kInscribedCost; cost < through.weight.size(); ++cost)
    if (through.weight[cost] == 0) through.weight[cost] = cost == kLethalCost ? 300 : 30;
  const auto status =
      search_.find(call.costs, through, call.in_cells(call.request.start), call.in_cells(goal), call.clock);
  if (status != GridSearch::Status::kFound) return error;
  const auto first = first_blocked(cells, search_.path());
  if (!first) return error;
  error.where = call.in_metres(*first);
  error.message = "no path from " + place_text(call.request.start) + " to " + place_text(goal) +
                  ": blocked at " + place_text(*error.where) +
                  "; clear that passage, map what is unknown there or choose another goal";
  return error;
}

}  // namespace

std::unique_ptr<GlobalPlanner> make_grid_planner(const GridPlannerParams& params) {
  return std::make_unique<GridPlanner>(params);
}

}  // namespace extperfc::navigate
