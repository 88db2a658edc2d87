#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/arm/time_parameterization.hpp"
#include "extperfc/simulate/joint_spline.hpp"

#include "test/unit/arm/trajectory/random_motion.hpp"

namespace extperfc::arm {
namespace {

constexpr double kCycleS = 1e-3;

/// What the simulated robot's trajectory follower makes of the points.
simulate::JointSpline follow(const std::vector<TrajectoryPoint>& points) {
  std::vector<simulate::JointKnot> knots;
  for (const auto& point : points) {
    simulate::JointKnot knot{point.time_s, point.position, Eigen::VectorXd(point.velocity), std::nullopt};
    if (point.acceleration) knot.acceleration = Eigen::VectorXd(*point.acceleration);
    knots.push_back(knot);
  }
  return simulate::JointSpline(knots);
}

struct Followed {
  double velocity{0};
  double acceleration{0};
  double off_path{0};  ///< from the trajectory, which is stretched to the same duration [rad]
};

Followed measure(const JointTrajectory& trajectory, const std::vector<TrajectoryPoint>& points) {
  const auto spline = follow(points);
  const double stretch = points.back().time_s / trajectory.duration_s();
  Followed result;
  for (double t = 0; t < spline.end_s(); t += kCycleS) {
    const auto motion = spline.sample(t);
    result.velocity = std::max(result.velocity, use(motion.velocity, trajectory.limits().velocity));
    result.acceleration =
        std::max(result.acceleration, use(motion.acceleration, trajectory.limits().acceleration));
    const JointVector off = motion.position - trajectory.sample(t / stretch).position;
    result.off_path = std::max(result.off_path, off.cwiseAbs().maxCoeff());
  }
  return result;
}

void expect_points_of(const JointTrajectory& trajectory, const std::vector<TrajectoryPoint>& points,
                      const std::vector<JointVector>& waypoints, const std::string& what) {
  EXPECT_EQ(points.front().time_s, 0) << what;
  EXPECT_LT((points.front().position - waypoints.front()).norm(), 1e-12) << what;
  EXPECT_EQ(points.back().position, waypoints.back()) << what;
  EXPECT_EQ(points.back().velocity.norm() < 1e-9, true) << what;
  for (std::size_t i = 1; i < points.size(); ++i)
    EXPECT_GT(points[i].time_s, points[i - 1].time_s + 1e-6) << what;
  for (const auto& point : points)
    EXPECT_NEAR(point.time_s * 1e9, std::round(point.time_s * 1e9), 1e-3) << what;
  const auto followed = measure(trajectory, points);
  EXPECT_LE(followed.velocity, 1 + 1e-9) << what;
  EXPECT_LE(followed.acceleration, 1 + 1e-9) << what;
}

JointTrajectory make(const std::vector<JointVector>& waypoints, const TrajectoryLimits& limits) {
  auto trajectory = parameterize(waypoints, 0.05, limits);
  EXPECT_TRUE(trajectory) << trajectory.error().message;
  return *std::move(trajectory);
}

struct Case {
  bool with_jerk;
  Interpolation interpolation;
};

class Followers : public testing::TestWithParam<Case> {};

TEST_P(Followers, KeepLimitsAndPathBetweenAdaptivePoints) {
  Rng rng(41);
  for (int trial = 0; trial < 40; ++trial) {
    const int joints = trial % 2 ? 7 : 14;
    const auto waypoints =
        random_waypoints(rng, joints, rng.integer(2, 6), std::pow(10, rng.uniform(-1.5, 0)));
    const auto trajectory = make(waypoints, random_limits(rng, joints, GetParam().with_jerk));
    PointParams params;
    params.interpolation = GetParam().interpolation;
    const auto points = to_points(trajectory, params);
    ASSERT_TRUE(points);
    const std::string what = "trial " + std::to_string(trial);
    expect_points_of(trajectory, *points, waypoints, what);
    EXPECT_LE(points->back().time_s, trajectory.duration_s() * 1.01) << what;
    EXPECT_LE(measure(trajectory, *points).off_path, params.tolerance_rad) << what;
    for (std::size_t i = 1; i < points->size(); ++i)
      EXPECT_LE((*points)[i].time_s - (*points)[i - 1].time_s, params.max_interval_s * 1.01) << what;
  }
}

TEST_P(Followers, KeepLimitsBetweenEvenPoints) {
  Rng rng(42);
  for (int trial = 0; trial < 20; ++trial) {
    const auto waypoints = random_waypoints(rng, 7, 4, 0.6);
    const auto trajectory = make(waypoints, random_limits(rng, 7, GetParam().with_jerk));
    PointParams params;
    params.interpolation = GetParam().interpolation;
    params.even_interval_s = 0.01;
    const auto points = to_points(trajectory, params);
    ASSERT_TRUE(points);
    const std::string what = "trial " + std::to_string(trial);
    expect_points_of(trajectory, *points, waypoints, what);
    // A cubic's end acceleration is the integral of (4 - 6 y) a(y) over the interval: 5/3 of the limit at
    // most.
    EXPECT_LE(points->back().time_s, trajectory.duration_s() * std::sqrt(5.0 / 3) * (1 + 1e-6)) << what;
    const double interval_s = points->back().time_s / static_cast<double>(points->size() - 1);
    for (std::size_t i = 1; i < points->size(); ++i)
      EXPECT_NEAR((*points)[i].time_s - (*points)[i - 1].time_s, interval_s, 2e-9) << what;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Followers,
                         testing::Values(Case{false, Interpolation::kCubic},
                                         Case{true, Interpolation::kCubic},
                                         Case{true, Interpolation::kQuintic}));

// Constant acceleration is a cubic: a straight needs no points but where acceleration changes.
TEST(TrajectoryPoints, AStraightNeedsFewPoints) {
  TrajectoryLimits limits{JointVector::Constant(1, 1.5), JointVector::Constant(1, 4)};
  const auto trajectory = make({JointVector::Zero(1), JointVector::Ones(1)}, limits);
  PointParams params;
  params.max_interval_s = 10;
  const auto points = to_points(trajectory, params);
  ASSERT_TRUE(points);
  EXPECT_EQ(points->size(), 4U);
  EXPECT_NEAR(points->back().time_s, trajectory.duration_s(), 1e-7);
}

TEST(TrajectoryPoints, TinyMotions) {
  Rng rng(43);
  for (const double size : {1e-6, 1e-4}) {
    const auto waypoints = random_waypoints(rng, 7, 2, size);
    for (const bool with_jerk : {false, true}) {
      const auto trajectory = make(waypoints, random_limits(rng, 7, with_jerk));
      const auto points = to_points(trajectory);
      ASSERT_TRUE(points);
      expect_points_of(trajectory, *points, waypoints, std::to_string(size));
    }
  }
}

TEST(TrajectoryPoints, AMotionOfNoTimeIsOnePoint) {
  TrajectoryLimits limits{JointVector::Ones(2), JointVector::Ones(2)};
  const auto points = to_points(make({JointVector::Ones(2)}, limits));
  ASSERT_TRUE(points);
  ASSERT_EQ(points->size(), 1U);
  EXPECT_EQ(points->front().position, JointVector::Ones(2));
}

TEST(TrajectoryPoints, BadParametersAreNamed) {
  TrajectoryLimits limits{JointVector::Ones(1), JointVector::Ones(1)};
  const auto trajectory = make({JointVector::Zero(1), JointVector::Ones(1)}, limits);
  const auto message = [&](const PointParams& params) {
    const auto points = to_points(trajectory, params);
    return points ? std::string("none") : points.error().message;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message({Interpolation::kQuintic}).find("accelerations jump"), std::string::npos);
  EXPECT_NE(message({Interpolation::kCubic, -1}).find("even_interval_s"), std::string::npos);
  EXPECT_NE(message({Interpolation::kCubic, 1e-9}).find("even_interval_s"), std::string::npos);
  EXPECT_NE(message({Interpolation::kCubic, 0, nan}).find("max_interval_s"), std::string::npos);
  EXPECT_NE(message({Interpolation::kCubic, 0, 0.1, 0}).find("tolerance_rad"), std::string::npos);
}

}  // namespace
}  // namespace extperfc::arm
