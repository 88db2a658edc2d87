#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/arm/time_parameterization.hpp"

#include "test/unit/arm/trajectory/random_motion.hpp"

namespace extperfc::arm {
namespace {

constexpr double kCycleS = 1e-3;
constexpr double kRounding = 1e-9;

JointVector one(double value) {
  return JointVector::Constant(1, value);
}

JointTrajectory make(const std::vector<JointVector>& waypoints, double deviation_rad,
                     const TrajectoryLimits& limits, const TimeParams& params = {}) {
  auto trajectory = parameterize(waypoints, deviation_rad, limits, params);
  EXPECT_TRUE(trajectory) << trajectory.error().message;
  return *std::move(trajectory);
}

/// Fastest motion of one joint from rest to rest with bounded speed v, acceleration a and jerk j: seven
/// phases, of which holding acceleration or speed may vanish.
double seven_phases_s(double distance, double v, double a, double j) {
  const double ramp_s = std::min(a / j, std::sqrt(v / j));
  const double accelerate_s = v * j >= a * a ? v / a + a / j : 2 * ramp_s;
  if (distance >= v * accelerate_s) return accelerate_s + distance / v;
  if (distance >= 2 * a * a * a / (j * j)) return a / j + std::sqrt(a * a / (j * j) + 4 * distance / a);
  return 4 * std::cbrt(distance / (2 * j));
}

struct Uses {
  double velocity{0};
  double acceleration{0};
  double jerk{0};
  double step{0};  ///< jerk by differences of accelerations
  double off{0};   ///< from the lines [rad]
};

Uses measure(const JointTrajectory& trajectory, const std::vector<JointVector>& waypoints, double cycle_s) {
  const auto& limits = trajectory.limits();
  Uses uses;
  auto before = trajectory.sample(0);
  for (int i = 0; i * cycle_s <= trajectory.duration_s() + cycle_s; ++i) {
    const auto now = trajectory.sample(i * cycle_s);
    uses.velocity = std::max(uses.velocity, use(now.velocity, limits.velocity));
    uses.acceleration = std::max(uses.acceleration, use(now.acceleration, limits.acceleration));
    uses.jerk = std::max(uses.jerk, use(*trajectory.jerk(i * cycle_s), *limits.jerk));
    uses.step = std::max(uses.step, use((now.acceleration - before.acceleration) / cycle_s, *limits.jerk));
    uses.off = std::max(uses.off, distance_to_polyline(now.position, waypoints));
    before = now;
  }
  return uses;
}

TEST(JerkLimits, RandomPathsKeepEveryBoundAtOneKilohertz) {
  Rng rng(31);
  for (int trial = 0; trial < 200; ++trial) {
    const int joints = trial % 2 ? 7 : 14;
    const auto waypoints = random_waypoints(rng, joints, rng.integer(2, 6), std::pow(10, rng.uniform(-2, 0)));
    const double deviation_rad = std::pow(10, rng.uniform(-4, -1));
    const auto limits = random_limits(rng, joints, true);
    const auto trajectory = make(waypoints, deviation_rad, limits);
    const auto uses = measure(trajectory, waypoints, kCycleS);
    const std::string what = "trial " + std::to_string(trial);
    EXPECT_LE(uses.velocity, 1 + kRounding) << what;
    EXPECT_LE(uses.acceleration, 1 + kRounding) << what;
    EXPECT_LE(uses.jerk, 1 + kRounding) << what;
    EXPECT_LE(uses.step, 1 + 1e-7) << what;  // differences of accelerations lose seven digits
    EXPECT_LE(uses.off, trajectory.deviation_rad() + 1e-9) << what;
    EXPECT_LE(trajectory.deviation_rad(), deviation_rad * (1 + 1e-12)) << what;
    EXPECT_LT((trajectory.sample(0).position - waypoints.front()).norm(), 1e-12) << what;
    EXPECT_EQ(trajectory.sample(trajectory.duration_s()).position, waypoints.back()) << what;
    EXPECT_LT((trajectory.sample(trajectory.duration_s() - 1e-9).position - waypoints.back()).norm(), 1e-9);
  }
}

// Positions, velocities and accelerations come from different formulas: they have to be one motion.
TEST(JerkLimits, DerivativesBelongToEachOther) {
  Rng rng(32);
  const double step = 1e-4;
  for (int trial = 0; trial < 20; ++trial) {
    const auto limits = random_limits(rng, 7, true);
    const auto trajectory = make(random_waypoints(rng, 7, 5, 0.5), trial % 2 ? 0.05 : 0, limits);
    for (double t = step; t < trajectory.duration_s() - step; t += 0.0037) {
      const auto before = trajectory.sample(t - step);
      const auto here = trajectory.sample(t);
      const auto behind = trajectory.sample(t + step);
      const JointVector moved = (behind.position - before.position) / (2 * step);
      const JointVector gained = (behind.velocity - before.velocity) / (2 * step);
      // Central differences: a sixth of the jerk times the step squared, half the jerk times the step.
      EXPECT_LE(use(moved - here.velocity, *limits.jerk), step * step) << t;
      EXPECT_LE(use(gained - here.acceleration, *limits.jerk), step) << t;
    }
  }
}

// Where accelerations jump one at a time, further apart than the window, the moving average is the fastest
// motion there is; short motions come near it in steps of the acceleration that is tried: 3.1 % slower at
// worst.
TEST(JerkLimits, OneJointAgainstTheClosedForm) {
  const double v = 1.5;
  const double a = 4;
  const double j = 40;
  TrajectoryLimits limits{one(v), one(a), one(j)};
  for (const double distance : {1e-6, 1e-4, 1e-2, 0.03, 0.05, 0.1, 0.3, 0.6}) {
    const double duration_s = make({one(0), one(distance)}, 0.05, limits).duration_s();
    const double best_s = seven_phases_s(distance, v, a, j);
    EXPECT_GE(duration_s, best_s * (1 - 1e-9)) << distance;
    EXPECT_LE(duration_s, best_s * 1.04) << distance;
  }
  for (const double distance : {0.75, 1.0, 3.0})  // v^2 / a + v a / j = 0.71 and more: speed is held
    EXPECT_NEAR(make({one(0), one(distance)}, 0.05, limits).duration_s(), seven_phases_s(distance, v, a, j),
                1e-3)
        << distance;
}

TEST(JerkLimits, StoppingMotionsStayOnTheirLines) {
  Rng rng(33);
  for (int trial = 0; trial < 20; ++trial) {
    const auto waypoints = random_waypoints(rng, 7, 5, 0.5);
    const auto trajectory = make(waypoints, 0, random_limits(rng, 7, true));
    EXPECT_EQ(trajectory.deviation_rad(), 0);
    EXPECT_EQ(trajectory.runs().size(), 4U);
    EXPECT_LT(measure(trajectory, waypoints, kCycleS).off, 1e-9);
    for (std::size_t i = 1; i < trajectory.runs().size(); ++i) {
      const auto stop = trajectory.sample(trajectory.runs()[i].begin_s);
      EXPECT_LT((stop.position - waypoints[i]).norm(), 1e-9);
      EXPECT_LT(stop.velocity.norm(), 1e-9);
    }
  }
}

TEST(JerkLimits, GenerousJerkCostsNextToNothing) {
  Rng rng(34);
  const auto waypoints = random_waypoints(rng, 7, 6, 0.6);
  auto limits = random_limits(rng, 7, false);
  const auto path = JointPath::make(waypoints);
  ASSERT_TRUE(path);
  const auto jumping = parameterize(*path, limits);
  limits.jerk = JointVector(1e5 * limits.acceleration);
  const auto smooth = parameterize(*path, limits);
  ASSERT_TRUE(jumping && smooth);
  EXPECT_GT(smooth->duration_s(), jumping->duration_s());
  EXPECT_LT(smooth->duration_s(), jumping->duration_s() + 2.1e-5);  // a window of 2 a / j at most
}

TEST(JerkLimits, TinyMotionsDoNotTakeTheWholeWindow) {
  Rng rng(35);
  for (const double size : {1e-6, 1e-4}) {
    const auto waypoints = random_waypoints(rng, 7, 2, size);
    const auto trajectory = make(waypoints, 0.05, random_limits(rng, 7, true));
    EXPECT_LT(trajectory.duration_s(), 0.15) << size;
    const auto uses = measure(trajectory, waypoints, trajectory.duration_s() / 1000);
    EXPECT_LE(std::max({uses.velocity, uses.acceleration, uses.jerk}), 1 + kRounding) << size;
    EXPECT_GT(uses.jerk, 0.9) << size;
  }
}

TEST(JerkLimits, LongPaths) {
  Rng rng(36);
  const auto waypoints = random_waypoints(rng, 7, 300, 0.3);
  const auto limits = random_limits(rng, 7, true);
  const auto trajectory = make(waypoints, 0.05, limits);
  double largest = 0;
  for (double t = 0; t < trajectory.duration_s(); t += kCycleS) {
    const auto state = trajectory.sample(t);
    largest =
        std::max({largest, use(state.velocity, limits.velocity), use(state.acceleration, limits.acceleration),
                  use(*trajectory.jerk(t), *limits.jerk)});
  }
  EXPECT_LE(largest, 1 + kRounding);
  EXPECT_GT(largest, 0.99);
}

}  // namespace
}  // namespace extperfc::arm
