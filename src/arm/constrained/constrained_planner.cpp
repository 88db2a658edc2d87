#include "extperfc/arm/constrained_planner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>

#include "extperfc/base/demand.hpp"

#include "arm/constrained/cbirrt.hpp"
#include "arm/constrained/manifold.hpp"
#include "arm/constrained/ompl_manifolds.hpp"
#include "arm/constrained/shortening.hpp"
#include "arm/planning/search_and_shorten.hpp"
#include "arm/planning/states.hpp"

namespace extperfc::arm {

namespace {

constexpr const char* kOwnPlanner = "cbirrt";
constexpr std::array<const char*, 5> kKinds{"axis", "plane", "line", "orientation", "relative pose"};
/// Maximum length of a direct path, relative to the distance.
constexpr double kMaxDetour = 2.0;

/// The first constraint that a state breaks.
std::optional<Violation> find_violation(const PathConstraint& constraint, double tolerance,
                                        const JointVector& state) {
  for (int c = 0; c < static_cast<int>(constraint.constraints().size()); ++c) {
    const double error = constraint.error(state, c);
    if (error <= tolerance) continue;
    const auto& broken = constraint.constraints()[static_cast<std::size_t>(c)];
    std::ostringstream message;
    message << "breaks constraint " << c << " (" << kKinds.at(static_cast<std::size_t>(broken.kind)) << " of "
            << broken.link << ") by " << error << ", " << tolerance << " at most";
    return Violation{c, message.str()};
  }
  return std::nullopt;
}

/// Straight along the manifold to a goal, the nearest first.
std::optional<Found> find_direct(Manifold& manifold, const Checked& checked, const Stop& stop) {
  for (const int goal : by_distance(checked.start, checked.goals)) {
    const double max_length = kMaxDetour * (checked.goals[goal] - checked.start).norm();
    auto pieces = manifold.connect(checked.start, checked.goals[goal], max_length, stop);
    if (!pieces) continue;
    pieces->insert(pieces->begin(), checked.start);
    return Found{*std::move(pieces), goal};
  }
  return std::nullopt;
}

std::optional<Found> find_path(Manifold& manifold, const ConstrainedPlannerParams& params,
                               const Checked& checked, const Stop& stop, int* states) {
  if (auto straight = find_direct(manifold, checked, stop)) return straight;
  Cbirrt trees(manifold, params.range_rad, params.max_states, checked.start, checked.goals);
  Rng rng(params.seed);
  auto found = trees.grow(std::numeric_limits<int>::max(), rng, stop);
  *states = trees.states();
  return found;
}

}  // namespace

const std::vector<std::string>& constrained_planner_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result{kOwnPlanner};
    const auto& others = ompl_manifold_planners();
    result.insert(result.end(), others.begin(), others.end());
    return result;
  }();
  return names;
}

ConstrainedPlanner::ConstrainedPlanner(CollisionChecker& checker, PathConstraint constraint,
                                       const ConstrainedPlannerParams& params)
    : checker_(checker),
      constraint_(std::move(constraint)),
      params_(params),
      limits_(bounded(checker.model().limits())) {
  demand_planner(params.planner, constrained_planner_names());
  demand_ranges(params);
  demand(constraint_.joint_count() == checker.model().joint_count(),
         "the constraint and the collision model are not about the same joints");
  demand(params.tolerance >= 1e-6 && params.tolerance <= 1e-2,
         "ConstrainedPlannerParams::tolerance: 1e-6 to 1e-2");
  demand(params.step_rad >= 0.01 && params.step_rad <= 0.5,
         "ConstrainedPlannerParams::step_rad: 0.01 to 0.5 rad");
}

ConstrainedPlanResult ConstrainedPlanner::plan(const PlanRequest& request) {
  Checked checked;
  const auto violation = [&](const JointVector& state) {
    return find_violation(constraint_, params_.tolerance, state);
  };
  if (auto refusal = check_request(checker_, limits_, params_.limit_repair_rad, request, checked, violation))
    return {*std::move(refusal), checked.violated, 0.0};
  Manifold manifold(checker_, constraint_, limits_, {params_.step_rad, params_.tolerance});
  const auto search = [&](const Stop& stop, int* states) -> std::optional<Found> {
    if (stop()) return std::nullopt;
    if (params_.planner != kOwnPlanner)
      return ompl_search(checker_, manifold, params_, checked.start, checked.goals, stop);
    return find_path(manifold, params_, checked, stop, states);
  };
  const auto shortening = [&](States waypoints, Rng& rng, const Stop& stop) {
    return shorten(manifold, std::move(waypoints), params_.shortcut_rounds, rng, stop);
  };
  ConstrainedPlanResult result{search_and_shorten(request, checked, params_, search, shortening)};
  result.error_bound = manifold.error_bound(result.waypoints);
  return result;
}

Result<std::vector<double>> corner_deviations(const PathConstraint& constraint,
                                              const std::vector<JointVector>& waypoints, double error,
                                              double smoothing_rad) {
  if (!(error > 0) || !(smoothing_rad >= 0) || !std::isfinite(error + smoothing_rad))
    return fail(ErrorCode::kInvalidArgument, "the error needs to be above 0, the smoothing 0 or more");
  for (const auto& waypoint : waypoints)
    if (waypoint.size() != constraint.joint_count() || !waypoint.allFinite())
      return fail(ErrorCode::kInvalidArgument,
                  "waypoints need " + std::to_string(constraint.joint_count()) + " finite joint values");
  std::vector<double> result(waypoints.size(), 0.0);
  double before = 0;
  for (std::size_t i = 0; i + 1 < waypoints.size(); ++i) {
    const double after = constraint.segment_error(waypoints[i], waypoints[i + 1]);
    const double length = std::max((waypoints[i + 1] - waypoints[i]).norm(),
                                   i > 0 ? (waypoints[i] - waypoints[i - 1]).norm() : 0.0);
    const double steepness = constraint.steepness(waypoints[i], length + smoothing_rad);
    const double left = (error - std::max(before, after)) / steepness - smoothing_rad;
    if (left < 0)
      return fail(ErrorCode::kInvalidArgument,
                  "the segments at waypoint " + std::to_string(i) + " leave no margin for the error");
    if (i > 0) result[i] = std::min(left, 1.0);
    before = after;
  }
  return result;
}

}  // namespace extperfc::arm
