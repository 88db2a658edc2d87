#include <cmath>
#include <limits>
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

/// Limits at 1 kHz, as values and as differences of positions and velocities between samples; ends; the way
/// from the lines.
void expect_sound(const JointTrajectory& trajectory, const std::vector<JointVector>& waypoints,
                  const std::string& what) {
  const auto& limits = trajectory.limits();
  double velocity = 0;
  double acceleration = 0;
  double off = 0;
  auto before = trajectory.sample(0);
  const auto cycles = static_cast<int>(trajectory.duration_s() / kCycleS);
  for (int i = 0; i <= cycles; ++i) {
    const auto now = trajectory.sample(i * kCycleS);
    const JointVector moved = (now.position - before.position) / kCycleS;
    const JointVector gained = (now.velocity - before.velocity) / kCycleS;
    velocity = std::max({velocity, use(now.velocity, limits.velocity), use(moved, limits.velocity)});
    acceleration = std::max(
        {acceleration, use(now.acceleration, limits.acceleration), use(gained, limits.acceleration)});
    off = std::max(off, distance_to_polyline(now.position, waypoints));
    before = now;
  }
  EXPECT_LE(velocity, 1 + kRounding) << what;
  EXPECT_LE(acceleration, 1 + kRounding) << what;
  EXPECT_LE(off, trajectory.deviation_rad() + 1e-9) << what;
  EXPECT_EQ(trajectory.sample(0).position, waypoints.front()) << what;
  EXPECT_EQ(trajectory.sample(trajectory.duration_s()).position, waypoints.back()) << what;
  EXPECT_LT((trajectory.sample(trajectory.duration_s() - 1e-9).position - waypoints.back()).norm(), 1e-8)
      << what;
}

TEST(TimeParameterization, OneJointIsBangBangOrTrapezoid) {
  for (const double distance : {1e-6, 1e-3, 0.1, 0.5, 1.0, 3.0}) {
    TrajectoryLimits limits{one(1.5), one(4)};
    const auto trajectory = make({one(0.2), one(0.2 + distance)}, 0.05, limits);
    const double expected = trapezoid_s(distance, 1.5, 4);
    EXPECT_NEAR(trajectory.duration_s(), expected, 1e-6 * expected) << distance;
    const auto middle = trajectory.sample(trajectory.duration_s() / 2);
    EXPECT_NEAR(middle.velocity[0], std::min(1.5, std::sqrt(distance * 4)), 1e-9);
    EXPECT_NEAR(trajectory.sample(1e-9 * expected).acceleration[0], 4, 1e-6);
    expect_sound(trajectory, {one(0.2), one(0.2 + distance)}, std::to_string(distance));
  }
}

// From speed v0 the closed form: up to v with (v^2 - v0^2) / 2a, hold, down to v1 with (v^2 - v1^2) / 2a.
TEST(TimeParameterization, SpeedsAtTheEndsAreKept) {
  TrajectoryLimits limits{one(1.5), one(4)};
  TimeParams params;
  params.start_speed = 1;
  params.end_speed = 0.5;
  const auto trajectory = make({one(0), one(2)}, 0.05, limits, params);
  const double gain = (1.5 * 1.5 - 1) / 8;
  const double loss = (1.5 * 1.5 - 0.25) / 8;
  EXPECT_NEAR(trajectory.duration_s(), 0.5 / 4 + 1.0 / 4 + (2 - gain - loss) / 1.5, 1e-9);
  EXPECT_NEAR(trajectory.sample(0).velocity[0], 1, 1e-9);
  EXPECT_NEAR(trajectory.sample(trajectory.duration_s()).velocity[0], 0.5, 1e-9);
}

TEST(TimeParameterization, SpeedsAtTheEndsThatCannotBeAreRefused) {
  TrajectoryLimits limits{one(1.5), one(4)};
  const auto error = [&](double start, double end, double distance) {
    TimeParams params;
    params.start_speed = start;
    params.end_speed = end;
    const auto result = parameterize({one(0), one(distance)}, 0.05, limits, params);
    return result ? std::string("none") : result.error().message;
  };
  EXPECT_EQ(error(1.5, 1.5, 1), "none");
  EXPECT_NE(error(1.6, 0, 1).find("start speed is 1.6 rad/s, the limits permit 0 to 1.5"), std::string::npos);
  EXPECT_NE(error(1.0, 0, 0.1).find("the limits permit 0 to 0.894"), std::string::npos);  // sqrt(2 * 4 * 0.1)
  EXPECT_NE(error(0, 1.6, 1).find("end speed of 1.6 rad/s is beyond"), std::string::npos);
  EXPECT_NE(error(0, 1.0, 0.1).find("the limits permit 0.447"), std::string::npos);  // sqrt(1 - 0.8)
  EXPECT_NE(error(1.0, 0, 0).find("without length"), std::string::npos);
}

TEST(TimeParameterization, RandomPathsKeepEveryBound) {
  Rng rng(21);
  for (int trial = 0; trial < 200; ++trial) {
    const int joints = trial % 2 ? 7 : 14;
    const auto waypoints = random_waypoints(rng, joints, rng.integer(2, 8), std::pow(10, rng.uniform(-2, 0)));
    const auto limits = random_limits(rng, joints, false);
    const double deviation_rad = std::pow(10, rng.uniform(-4, -1));
    const auto trajectory = make(waypoints, deviation_rad, limits);
    const std::string what = "trial " + std::to_string(trial);
    expect_sound(trajectory, waypoints, what);
    EXPECT_LE(trajectory.deviation_rad(), deviation_rad * (1 + 1e-12)) << what;
    // The grid may cost more than rounding gains where a sharp corner has a millirad of room: 0.12 % was the
    // most in 20,000 random corners.
    EXPECT_LE(trajectory.duration_s(), stop_and_go_s(waypoints, limits) * 1.002) << what;
    double smallest = 0;  // each joint alone, end to end
    for (int j = 0; j < joints; ++j)
      smallest = std::max(smallest, trapezoid_s(std::abs(waypoints.back()[j] - waypoints.front()[j]),
                                                limits.velocity[j], limits.acceleration[j]));
    EXPECT_GE(trajectory.duration_s(), smallest * (1 - 1e-9)) << what;
  }
}

// Without deviation the motion is the trapezoids of its lines, one behind the other.
TEST(TimeParameterization, StopAndGoIsTheSumOfItsLines) {
  Rng rng(22);
  for (int trial = 0; trial < 20; ++trial) {
    const auto waypoints = random_waypoints(rng, 7, 6, 0.7);
    const auto limits = random_limits(rng, 7, false);
    const auto trajectory = make(waypoints, 0, limits);
    const double expected = stop_and_go_s(waypoints, limits);
    EXPECT_NEAR(trajectory.duration_s(), expected, 1e-9 * expected);
    expect_sound(trajectory, waypoints, "trial " + std::to_string(trial));
  }
}

// Pontryagin: in a time-optimal motion some limit is active at almost every instant. Where none is, a faster
// law exists: this is what a solver that is too careful fails.
TEST(TimeParameterization, SomeLimitIsActiveAllTheTime) {
  Rng rng(23);
  TimeParams params;
  params.stages_per_corner = 100;
  int active = 0;
  int samples = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const auto limits = random_limits(rng, 7, false);
    const auto trajectory = make(random_waypoints(rng, 7, 5, 0.8), 0.05, limits, params);
    for (double t = 0; t < trajectory.duration_s(); t += kCycleS, ++samples) {
      const auto state = trajectory.sample(t);
      const double largest =
          std::max(use(state.velocity, limits.velocity), use(state.acceleration, limits.acceleration));
      active += largest > 0.97 ? 1 : 0;
    }
  }
  EXPECT_GT(active, 0.95 * samples) << active << " of " << samples;
}

TEST(TimeParameterization, TheDefaultGridIsNearAFineOne) {
  Rng rng(24);
  TimeParams fine;
  fine.stages_per_corner = 200;
  for (int trial = 0; trial < 20; ++trial) {
    const auto waypoints = random_waypoints(rng, 7, 8, 0.6);
    const auto limits = random_limits(rng, 7, false);
    const double coarse_s = make(waypoints, 0.05, limits).duration_s();
    EXPECT_LE(coarse_s, 1.02 * make(waypoints, 0.05, limits, fine).duration_s()) << trial;
  }
}

// Joints that turn around inside a corner have no say on acceleration along the path there (zero inertia):
// time parameterizations from values at grid points oscillate or stall at such places.
TEST(TimeParameterization, TurningJointsNeitherStallNorOscillate) {
  for (const double tilt : {0.0, 1e-9, 1e-4, 0.3}) {
    std::vector<JointVector> waypoints;
    for (int i = 0; i < 6; ++i) {
      JointVector q(3);
      q << 0.4 * i, 0.2 * (i % 2), tilt * i * (i % 3);
      waypoints.push_back(q);
    }
    TrajectoryLimits limits{JointVector::Constant(3, 2), JointVector::Constant(3, 5)};
    const auto trajectory = make(waypoints, 0.05, limits);
    expect_sound(trajectory, waypoints, "tilt " + std::to_string(tilt));
    EXPECT_LE(trajectory.duration_s(), stop_and_go_s(waypoints, limits));
    double slowest = 10;
    int changes = 0;
    double before = 0;
    for (const auto& phase : trajectory.phases()) {
      if (phase.begin_s > 0) slowest = std::min(slowest, phase.speed);
      if (phase.acceleration * before < 0) ++changes;
      if (phase.acceleration != 0) before = phase.acceleration;
    }
    EXPECT_GT(slowest, 0.2) << "it all but stands somewhere";
    // A line: gain, lose; a corner with one turning joint: lose, gain, lose, gain at most.
    EXPECT_LE(changes, 5 * 2 + 4 * 4) << "acceleration flips from stage to stage";
  }
}

TEST(TimeParameterization, ScalesSlowDownAsLimitsWould) {
  Rng rng(25);
  const auto waypoints = random_waypoints(rng, 7, 6, 0.8);
  auto limits = random_limits(rng, 7, false);
  TimeParams params;
  params.velocity_scale = 0.5;
  params.acceleration_scale = 0.25;  // both by time: everything takes twice as long
  const double slow = make(waypoints, 0.05, limits, params).duration_s();
  EXPECT_NEAR(slow, 2 * make(waypoints, 0.05, limits).duration_s(), 1e-9 * slow);
  const auto scaled = make(waypoints, 0.05, limits, params).limits();
  EXPECT_TRUE(scaled.velocity.isApprox(0.5 * limits.velocity));
  EXPECT_TRUE(scaled.acceleration.isApprox(0.25 * limits.acceleration));
}

TEST(TimeParameterization, TinyMotionsWithCorners) {
  Rng rng(26);
  for (const double size : {1e-6, 1e-5, 1e-3}) {
    const auto waypoints = random_waypoints(rng, 7, 4, size);
    const auto limits = random_limits(rng, 7, false);
    const auto trajectory = make(waypoints, 0.05, limits);
    EXPECT_LE(trajectory.duration_s(), stop_and_go_s(waypoints, limits));
    double largest = 0;
    for (int i = 0; i <= 1000; ++i) {
      const auto state = trajectory.sample(trajectory.duration_s() * i / 1000);
      largest = std::max(
          {largest, use(state.velocity, limits.velocity), use(state.acceleration, limits.acceleration)});
    }
    EXPECT_LE(largest, 1 + kRounding) << size;
    EXPECT_GT(largest, 0.99) << size;
  }
}

TEST(TimeParameterization, NearlyStraightDensePathsDoNotSlowDown) {
  std::vector<JointVector> dense;
  JointVector a = JointVector::Zero(7);
  JointVector b = JointVector::LinSpaced(7, 0.5, 1.5);
  for (int i = 0; i <= 300; ++i) dense.emplace_back(a + (b - a) * (i / 300.0));
  TrajectoryLimits limits{JointVector::Constant(7, 1.5), JointVector::Constant(7, 4)};
  for (const double deviation_rad : {0.0, 0.05})
    EXPECT_NEAR(make(dense, deviation_rad, limits).duration_s(), line_s(a, b, limits), 1e-6) << deviation_rad;
}

TEST(TimeParameterization, AThousandWaypoints) {
  Rng rng(27);
  const auto waypoints = random_waypoints(rng, 7, 1000, 0.3);
  const auto limits = random_limits(rng, 7, false);
  const auto trajectory = make(waypoints, 0.05, limits);
  EXPECT_LE(trajectory.phases().size(), 1000U * (16 + 3));
  EXPECT_LE(trajectory.duration_s(), stop_and_go_s(waypoints, limits));
  double largest = 0;
  for (double t = 0; t < trajectory.duration_s(); t += kCycleS) {
    const auto state = trajectory.sample(t);
    largest = std::max(
        {largest, use(state.velocity, limits.velocity), use(state.acceleration, limits.acceleration)});
  }
  EXPECT_LE(largest, 1 + kRounding);
}

TEST(TimeParameterization, TheSameInputGivesTheSameMotion) {
  Rng rng(28);
  const auto waypoints = random_waypoints(rng, 14, 7, 0.6);
  for (const bool with_jerk : {false, true}) {
    const auto limits = random_limits(rng, 14, with_jerk);
    const auto a = make(waypoints, 0.05, limits);
    const auto b = make(waypoints, 0.05, limits);
    ASSERT_EQ(a.duration_s(), b.duration_s());
    for (double t = 0; t < a.duration_s(); t += 0.01) ASSERT_EQ(a.sample(t).position, b.sample(t).position);
  }
}

TEST(TimeParameterization, OneWaypointIsAMotionOfNoTime) {
  TrajectoryLimits limits{one(1), one(1)};
  for (const bool with_jerk : {false, true}) {
    if (with_jerk) limits.jerk = one(10);
    const auto trajectory = make({one(0.7)}, 0.05, limits);
    EXPECT_EQ(trajectory.duration_s(), 0);
    EXPECT_EQ(trajectory.sample(0.5).position, one(0.7));
    EXPECT_EQ(trajectory.sample(0.5).velocity, one(0));
    EXPECT_EQ(trajectory.borders_s(), std::vector<double>{0.0});
  }
}

TEST(TimeParameterization, BadInputIsNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<JointVector> waypoints{one(0), one(1)};
  const auto message = [&](const TrajectoryLimits& limits, const TimeParams& params = {}) {
    const auto result = parameterize(waypoints, 0.05, limits, params);
    if (result) return std::string("none");
    EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument);
    return result.error().message;
  };
  const auto has = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(has(message({JointVector::Ones(2), one(1)}), "velocity limits of 2 joints for a path of 1"));
  EXPECT_TRUE(has(message({one(0), one(1)}), "velocity limit of joint 0"));
  EXPECT_TRUE(has(message({one(1), one(-1)}), "acceleration limit of joint 0"));
  EXPECT_TRUE(has(message({one(1), one(nan)}), "acceleration limit of joint 0"));
  EXPECT_TRUE(has(message({one(1), one(1), one(0)}), "jerk limit of joint 0"));
  for (const double bad : {0.0, 1.01, -1.0, nan}) {
    TimeParams params;
    params.velocity_scale = bad;
    EXPECT_TRUE(has(message({one(1), one(1)}, params), "velocity_scale"));
    params.velocity_scale = 1;
    params.acceleration_scale = bad;
    EXPECT_TRUE(has(message({one(1), one(1)}, params), "acceleration_scale"));
  }
  TimeParams params;
  params.start_speed = -1;
  EXPECT_TRUE(has(message({one(1), one(1)}, params), "start_speed"));
  params.start_speed = 0.5;
  EXPECT_TRUE(has(message({one(1), one(1), one(10)}, params), "must be 0 with jerk limits"));
  params.start_speed = 0;
  params.stages_per_corner = 1;
  EXPECT_TRUE(has(message({one(1), one(1)}, params), "stages_per_corner"));
}

}  // namespace
}  // namespace extperfc::arm
