#include "extperfc/arm/constrained_planner.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "extperfc/base/stopwatch.hpp"

#include "arm/constrained/cbirrt.hpp"
#include "arm/constrained/manifold.hpp"
#include "arm/constrained/ompl_manifolds.hpp"
#include "arm/constrained/request_validator.hpp"
#include "arm/constrained/shortening.hpp"

namespace extperfc::arm {

namespace {

constexpr const char* kOwnPlanner = "cbirrt";
constexpr double kPi = 3.14159265358979323846;

void demand(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

JointLimits bounded(JointLimits limits) {
  for (Eigen::Index j = 0; j < limits.lower.size(); ++j) {
    if (!std::isfinite(limits.lower[j])) limits.lower[j] = -kPi;
    if (!std::isfinite(limits.upper[j])) limits.upper[j] = kPi;
  }
  return limits;
}

}  // namespace

const std::vector<std::string>& constrained_planner_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result{kOwnPlanner};
    const auto& others = constrained::ompl_planners();
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
  const auto& names = constrained_planner_names();
  if (std::find(names.begin(), names.end(), params.planner) == names.end())
    throw std::invalid_argument("ConstrainedPlannerParams::planner: '" + params.planner +
                                "' is not one of constrained_planner_names()");
  demand(constraint_.joint_count() == checker.model().joint_count(),
         "the constraint and the collision model are not about the same joints");
  demand(params.tolerance >= 1e-6 && params.tolerance <= 1e-2,
         "ConstrainedPlannerParams::tolerance: 1e-6 to 1e-2");
  demand(params.range_rad >= 0.05 && params.range_rad <= 3.0,
         "ConstrainedPlannerParams::range_rad: 0.05 to 3 rad");
  demand(params.step_rad >= 0.01 && params.step_rad <= 0.5,
         "ConstrainedPlannerParams::step_rad: 0.01 to 0.5 rad");
  demand(params.timeout_s > 0.0, "ConstrainedPlannerParams::timeout_s: more than 0 s");
  demand(params.max_states >= 2 && params.max_states <= 10'000'000,
         "ConstrainedPlannerParams::max_states: 2 to 10,000,000");
  demand(params.shortcut_rounds >= 0 && params.shortcut_rounds <= 10'000,
         "ConstrainedPlannerParams::shortcut_rounds: 0 to 10,000");
  demand(params.limit_repair_rad >= 0.0 && params.limit_repair_rad <= 0.2,
         "ConstrainedPlannerParams::limit_repair_rad: 0 to 0.2 rad");
}

std::optional<constrained::Found> ConstrainedPlanner::search(const JointVector& start,
                                                             const std::vector<JointVector>& goals,
                                                             const std::function<bool()>& stop, int* states) {
  constrained::Manifold manifold(checker_, constraint_, limits_, {params_.step_rad, params_.tolerance});
  if (stop()) return std::nullopt;
  if (params_.planner != kOwnPlanner)
    return constrained::ompl_search(checker_, manifold, params_, start, goals, stop);
  if (auto direct = constrained::direct(manifold, start, goals, stop)) return direct;
  constrained::Cbirrt trees(manifold, params_.range_rad, params_.max_states, start, goals);
  Rng rng(params_.seed);
  auto found = trees.grow(rng, stop);
  *states = trees.states();
  return found;
}

ConstrainedPlanResult ConstrainedPlanner::plan(const PlanRequest& request) {
  const constrained::RequestValidator gate(checker_, constraint_, limits_, params_);
  constrained::Checked checked;
  if (auto refusal = gate.shape(request)) return *refusal;
  if (auto refusal = gate.start(request, &checked)) return *refusal;
  if (auto refusal = gate.goals(request, &checked)) return *refusal;

  bool cancelled = false;
  const Stopwatch watch;
  const auto asked_to_stop = [&] {
    return cancelled = cancelled || (request.cancelled && request.cancelled());
  };
  const auto stop = [&] { return asked_to_stop() || watch.seconds() > params_.timeout_s; };
  ConstrainedPlanResult result;
  auto found = search(checked.start, checked.goals, stop, &result.states);
  result.search_s = watch.seconds();
  if (!found) {
    result.code = cancelled ? PlanCode::kCancelled : PlanCode::kTimeout;
    result.message = cancelled
                         ? "cancelled"
                         : "no path that keeps the constraint within " + std::to_string(params_.timeout_s) +
                               " s and " + std::to_string(params_.max_states) + " states";
    return result;
  }
  constrained::Manifold manifold(checker_, constraint_, limits_, {params_.step_rad, params_.tolerance});
  Rng rng(params_.seed);
  result.waypoints = constrained::shorten(manifold, std::move(found->waypoints), params_.shortcut_rounds, rng,
                                          asked_to_stop);
  result.shortcut_s = watch.seconds() - result.search_s;
  if (cancelled) return constrained::refused(PlanCode::kCancelled, "cancelled");
  result.code = PlanCode::kSuccess;
  result.goal = checked.goal_indices[found->goal];
  result.length_rad = path_length(result.waypoints);
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
