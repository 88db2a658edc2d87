#include "arm/trajectory/smoothing.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "arm/trajectory/stage_bounds.hpp"

namespace extperfc::arm {

namespace {

constexpr int kBisections = 12;
constexpr int kSteps = 80;            // down to 1e-12 of the acceleration limit: motions of 1e-9 rad
constexpr double kStep = 0.70710678;  // of the fraction of the limit that is used
constexpr double kFineStep = 0.84089642;

/// Accelerations per phase, in units of the jerk limit [s], rest before and behind them.
struct AccelerationCourse {
  std::vector<JointInterval> ranges;  ///< phases + 2
  std::vector<double> ends_s;         ///< of each range but the last, which has none
};

AccelerationCourse course(const JointPath& path, const std::vector<PathPhase>& phases,
                          const JointVector& jerk) {
  const JointVector rest = JointVector::Zero(jerk.size());
  AccelerationCourse result;
  result.ranges.push_back({rest, rest});
  result.ends_s.push_back(0);
  for (const auto& phase : phases) {
    const auto range = acceleration_range(path.pieces()[phase.piece], phase);
    result.ranges.push_back({range.lower.cwiseQuotient(jerk), range.upper.cwiseQuotient(jerk)});
    result.ends_s.push_back(phase.begin_s + phase.duration_s);
  }
  result.ranges.push_back({rest, rest});
  return result;
}

/// Largest difference of accelerations `window_s` apart, over the jerk limits [s].
double largest_change(const AccelerationCourse& course, double window_s) {
  const auto& ends = course.ends_s;
  std::size_t early = 0;
  std::size_t late = 0;
  double largest = 0;
  while (early < ends.size()) {
    const auto& a = course.ranges[early];
    const auto& b = course.ranges[late];
    largest = std::max({largest, (a.upper - b.lower).maxCoeff(), (b.upper - a.lower).maxCoeff()});
    if (late < ends.size() && ends[late] - window_s <= ends[early])
      ++late;
    else
      ++early;
  }
  return largest;
}

/// Largest Euclidean norm over all joints [rad/s^2].
double largest_acceleration(const JointPath& path, const std::vector<PathPhase>& phases) {
  double largest = 0;
  for (const auto& phase : phases) {
    const auto range = acceleration_range(path.pieces()[phase.piece], phase);
    largest = std::max(largest, range.lower.cwiseAbs().cwiseMax(range.upper.cwiseAbs()).norm());
  }
  return largest;
}

bool has_corner(const JointPath& path, const Passage& passage) {
  const auto first = path.pieces().begin() + static_cast<std::ptrdiff_t>(passage.first_piece);
  return std::any_of(first, first + static_cast<std::ptrdiff_t>(passage.pieces),
                     [](const PathPiece& piece) { return !piece.straight; });
}

Result<SmoothPassage> attempt(const JointPath& path, const Passage& passage, const TrajectoryLimits& limits,
                              double fraction, int stages) {
  auto phases = fastest_phases(path, passage, limits.velocity, fraction * limits.acceleration, stages);
  if (!phases) return tl::unexpected(phases.error());
  SmoothPassage result{*std::move(phases)};
  result.window_s = smoothing_window(path, result.phases, *limits.jerk);
  if (has_corner(path, passage))
    result.deviation_rad = largest_acceleration(path, result.phases) * result.window_s * result.window_s / 24;
  return result;
}

/// Largest acceleration over the jerk limit [s]: no window can be shorter.
double min_window(const AccelerationCourse& course) {
  double smallest = 0;
  for (const auto& range : course.ranges)
    smallest = std::max(smallest, range.lower.cwiseAbs().cwiseMax(range.upper.cwiseAbs()).maxCoeff());
  return smallest * (1 + 1e-11);
}

/// With speed held on straights for as long as the shortest window, where that is shorter in the end.
Result<SmoothPassage> better_attempt(const JointPath& path, const Passage& passage,
                                     const TrajectoryLimits& limits, double fraction, int stages) {
  auto plain = attempt(path, passage, limits, fraction, stages);
  if (!plain) return plain;
  const double min_window_s = min_window(course(path, plain->phases, *limits.jerk));
  if (plain->window_s <= min_window_s * (1 + 1e-6)) return plain;
  Passage holding = passage;
  holding.hold_s = min_window_s * (1 + 1e-6);  // above what rounding may take away
  auto held = attempt(path, holding, limits, fraction, stages);
  if (!held || held->duration_s() < plain->duration_s()) return held;
  return plain;
}

}  // namespace

double smoothing_window(const JointPath& path, const std::vector<PathPhase>& phases,
                        const JointVector& jerk) {
  const auto accelerations = course(path, phases, jerk);
  double smallest = min_window(accelerations);
  const auto holds = [&](double window_s) { return largest_change(accelerations, window_s) <= window_s; };
  if (holds(smallest)) return smallest;
  double enough = 2 * smallest;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = (smallest + enough) / 2;
    (holds(middle) ? enough : smallest) = middle;
  }
  return enough;
}

Result<SmoothPassage> smooth_passage(const JointPath& path, const Passage& passage,
                                     const TrajectoryLimits& limits, double deviation_rad, int stages) {
  std::optional<SmoothPassage> best;
  double best_fraction = 1;
  bool better = false;
  const auto consider = [&](double fraction) -> Result<void> {
    auto result = better_attempt(path, passage, limits, fraction, stages);
    if (!result) return tl::unexpected(result.error());
    better = result->deviation_rad <= deviation_rad && (!best || result->duration_s() < best->duration_s());
    if (!better) return {};
    best = *std::move(result);
    best_fraction = fraction;
    return {};
  };
  double fraction = 1;
  for (int step = 0; step < kSteps && (better || !best); ++step, fraction *= kStep)
    if (auto done = consider(fraction); !done) return tl::unexpected(done.error());
  if (!best)
    return fail(ErrorCode::kInvalidArgument,
                "time parameterization: no acceleration is low enough to keep within smoothing_deviation_rad "
                "of the path");
  const double middle = best_fraction;
  for (const double factor : {1 / kFineStep, kFineStep})
    if (middle * factor < 1)
      if (auto done = consider(middle * factor); !done) return tl::unexpected(done.error());
  return *std::move(best);
}

}  // namespace extperfc::arm
