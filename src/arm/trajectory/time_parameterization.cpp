#include "extperfc/arm/time_parameterization.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "arm/trajectory/reachability.hpp"
#include "arm/trajectory/smoothing.hpp"

namespace extperfc::arm {

namespace {

tl::unexpected<Error> invalid(const std::string& why) {
  return fail(ErrorCode::kInvalidArgument, "time parameterization: " + why);
}

Result<void> check_limit(const char* name, const JointVector& limit, Eigen::Index joints) {
  if (limit.size() != joints)
    return invalid(std::string(name) + " limits of " + std::to_string(limit.size()) +
                   " joints for a path of " + std::to_string(joints));
  for (Eigen::Index j = 0; j < joints; ++j)
    if (!std::isfinite(limit[j]) || limit[j] <= 0)
      return invalid(std::string(name) + " limit of joint " + std::to_string(j) + " is " +
                     std::to_string(limit[j]) + ", it must be positive and finite");
  return {};
}

Result<void> check_limits(const TrajectoryLimits& limits, Eigen::Index joints) {
  if (auto checked = check_limit("velocity", limits.velocity, joints); !checked) return checked;
  if (auto checked = check_limit("acceleration", limits.acceleration, joints); !checked) return checked;
  return limits.jerk ? check_limit("jerk", *limits.jerk, joints) : Result<void>{};
}

Result<void> check_params(const TimeParams& params, bool with_jerk) {
  const auto fraction = [](double value) { return value > 0 && value <= 1; };
  const auto speed = [](double value) { return value >= 0 && std::isfinite(value); };
  if (!fraction(params.velocity_scale)) return invalid("velocity_scale must lie in (0, 1]");
  if (!fraction(params.acceleration_scale)) return invalid("acceleration_scale must lie in (0, 1]");
  if (!speed(params.start_speed)) return invalid("start_speed must be finite and not negative");
  if (!speed(params.end_speed)) return invalid("end_speed must be finite and not negative");
  if (params.stages_per_corner < 4 || params.stages_per_corner > 200)
    return invalid("stages_per_corner must lie in [4, 200]");
  if (!with_jerk) return {};
  if (!fraction(params.smoothing_deviation_rad)) return invalid("smoothing_deviation_rad must lie in (0, 1]");
  if (params.start_speed > 0 || params.end_speed > 0)
    return invalid("start_speed and end_speed must be 0 with jerk limits");
  return {};
}

/// The path cut at its stops.
std::vector<Passage> passages(const JointPath& path, const TimeParams& params) {
  std::vector<Passage> all;
  for (std::size_t i = 0; i < path.pieces().size(); ++i) {
    if (i == 0 || path.pieces()[i - 1].stop_after) all.push_back({i, 0});
    ++all.back().pieces;
  }
  if (all.empty()) return all;
  all.front().start_speed = params.start_speed;
  all.back().end_speed = params.end_speed;
  return all;
}

Result<SmoothPassage> time_passage(const JointPath& path, const Passage& passage,
                                   const TrajectoryLimits& limits, const TimeParams& params) {
  if (limits.jerk)
    return smooth_passage(path, passage, limits, params.smoothing_deviation_rad, params.stages_per_corner);
  auto phases = fastest_phases(path, passage, limits.velocity, limits.acceleration, params.stages_per_corner);
  if (!phases) return tl::unexpected(phases.error());
  return SmoothPassage{*std::move(phases)};
}

}  // namespace

Result<JointTrajectory> parameterize(const JointPath& path, const TrajectoryLimits& limits,
                                     const TimeParams& params) {
  if (auto checked = check_limits(limits, path.joints()); !checked) return tl::unexpected(checked.error());
  if (auto checked = check_params(params, limits.jerk.has_value()); !checked)
    return tl::unexpected(checked.error());
  if (path.pieces().empty() && (params.start_speed > 0 || params.end_speed > 0))
    return invalid("a path without length cannot start or end in motion");
  TrajectoryLimits scaled = limits;
  scaled.velocity *= params.velocity_scale;
  scaled.acceleration *= params.acceleration_scale;
  std::vector<PathPhase> phases;
  std::vector<TrajectoryRun> runs;
  double time_s = 0;
  double smoothing = 0;
  for (const auto& passage : passages(path, params)) {
    const auto timed = time_passage(path, passage, scaled, params);
    if (!timed) return tl::unexpected(timed.error());
    runs.push_back({time_s, timed->duration_s() - timed->window_s, timed->window_s, phases.size(),
                    timed->phases.size()});
    phases.insert(phases.end(), timed->phases.begin(), timed->phases.end());
    time_s += timed->duration_s();
    smoothing = std::max(smoothing, timed->deviation_rad);
  }
  return JointTrajectory(path, std::move(scaled), std::move(phases), std::move(runs), smoothing);
}

Result<JointTrajectory> parameterize(const std::vector<JointVector>& waypoints, double deviation_rad,
                                     const TrajectoryLimits& limits, const TimeParams& params) {
  JointPathParams shape;
  shape.deviation_rad = limits.jerk ? deviation_rad / 2 : deviation_rad;
  TimeParams timing = params;
  if (deviation_rad > 0) timing.smoothing_deviation_rad = std::min(1.0, deviation_rad / 2);
  const auto path = JointPath::make(waypoints, shape);
  if (!path) return tl::unexpected(path.error());
  return parameterize(*path, limits, timing);
}

}  // namespace extperfc::arm
