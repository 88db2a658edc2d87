#include "test/benchmark/arm/trajectory_part.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <iterator>
#include <string>
#include <utility>

#include "extperfc/arm/time_parameterization.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/base/stopwatch.hpp"

namespace extperfc::benchmark {
namespace {

using arm::JointVector;

constexpr int kJoints = 7;
constexpr double kDeviationRad = 0.05;
constexpr double kCycleS = 1e-3;

/// Velocity limits of Baxter's description, which has none of acceleration and jerk: full speed in about half
/// a second, full acceleration in a tenth.
arm::TrajectoryLimits baxter_limits(bool with_jerk) {
  arm::TrajectoryLimits limits{JointVector(kJoints), JointVector(kJoints)};
  limits.velocity << 1.5, 1.5, 1.5, 1.5, 4, 4, 4;
  limits.acceleration << 4, 4, 4, 4, 8, 8, 8;
  if (with_jerk) limits.jerk = JointVector(10 * limits.acceleration);
  return limits;
}

std::vector<JointVector> random_waypoints(Rng& rng, int count) {
  std::vector<JointVector> waypoints{JointVector::Zero(kJoints)};
  while (static_cast<int>(waypoints.size()) < count) {
    JointVector next = waypoints.back();
    for (int j = 0; j < kJoints; ++j) next[j] = std::clamp(next[j] + rng.uniform(-0.5, 0.5), -1.5, 1.5);
    waypoints.push_back(next);
  }
  return waypoints;
}

/// Trapezoids of speed along each line, one behind the other.
double stop_and_go_s(const std::vector<JointVector>& waypoints, const arm::TrajectoryLimits& limits) {
  double sum_s = 0;
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    const auto delta = (waypoints[i] - waypoints[i - 1]).array().abs().eval();
    const double speed = 1 / (delta / limits.velocity.array()).maxCoeff();  // in path lengths per second
    const double gain = 1 / (delta / limits.acceleration.array()).maxCoeff();
    sum_s += gain <= speed * speed ? 2 / std::sqrt(gain) : 1 / speed + speed / gain;
  }
  return sum_s;
}

double use(const JointVector& values, const JointVector& limit) {
  return (values.array() / limit.array()).abs().maxCoeff();
}

/// Largest fraction of any limit at 1 kHz.
double largest_use(const arm::JointTrajectory& trajectory) {
  const auto& limits = trajectory.limits();
  double largest = 0;
  for (double t = 0; t < trajectory.duration_s(); t += kCycleS) {
    const auto state = trajectory.sample(t);
    largest = std::max(
        {largest, use(state.velocity, limits.velocity), use(state.acceleration, limits.acceleration)});
    if (limits.jerk) largest = std::max(largest, use(*trajectory.jerk(t), *limits.jerk));
  }
  return largest;
}

struct Sums {
  double time_parameterization_s{0};  ///< CPU
  double points_s{0};                 ///< CPU
  double duration_s{0};
  double stop_and_go_s{0};
  double points{0};
  double max_use{0};
  double max_stretch{0};  ///< duration of the points over the trajectory's
};

Result<void> add(const std::vector<JointVector>& waypoints, const arm::TrajectoryLimits& limits, Sums& sums) {
  const CpuStopwatch law;
  const auto trajectory = arm::parameterize(waypoints, kDeviationRad, limits);
  if (!trajectory) return tl::unexpected(trajectory.error());
  sums.time_parameterization_s += law.seconds();
  const CpuStopwatch conversion;
  const auto points = arm::to_points(*trajectory);
  if (!points) return tl::unexpected(points.error());
  sums.points_s += conversion.seconds();
  sums.points += static_cast<double>(points->size());
  sums.duration_s += trajectory->duration_s();
  sums.stop_and_go_s += stop_and_go_s(waypoints, limits);
  sums.max_use = std::max(sums.max_use, largest_use(*trajectory));
  sums.max_stretch = std::max(sums.max_stretch, points->back().time_s / trajectory->duration_s());
  return {};
}

std::vector<Row> rows_of(int waypoints, bool with_jerk, int paths) {
  Rng rng(4711);
  Sums sums;
  for (int i = 0; i < paths; ++i) {
    const auto added = add(random_waypoints(rng, waypoints), baxter_limits(with_jerk), sums);
    if (added) continue;
    std::cerr << "trajectory: " << added.error().message << "\n";
    return {};
  }
  const std::string name = "time parameterization, " + std::to_string(waypoints) + " waypoints" +
                           (with_jerk ? ", jerk limits" : "");
  const double count = paths;
  const char* peer = "stop at every waypoint, no jerk limit";
  return {{name, "CPU time of the time parameterization", "ms", 1e3 * sums.time_parameterization_s / count},
          {name, "CPU time of its points", "ms", 1e3 * sums.points_s / count},
          {name, "points", "1", sums.points / count},
          {name, "duration", "s", sums.duration_s / count, sums.stop_and_go_s / count, peer},
          at_most({name, "largest fraction of a limit at 1 kHz", "1", sums.max_use}, 1 + 1e-9),
          at_most({name, "stretch that the points need", "1", sums.max_stretch}, 1.01)};
}

}  // namespace

std::vector<Row> trajectory_rows(bool quick) {
  std::vector<Row> rows;
  for (const bool with_jerk : {false, true})
    for (const int waypoints : {2, 10, 50, 200}) {
      const int paths = std::max(2, (quick ? 40 : 400) / waypoints);
      auto more = rows_of(waypoints, with_jerk, paths);
      std::move(more.begin(), more.end(), std::back_inserter(rows));
    }
  return rows;
}

}  // namespace extperfc::benchmark
