#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/arm/time_parameterization.hpp"

#include "test/unit/arm/constrained/level_arm.hpp"

namespace extperfc::arm {
namespace {

using test::constraint_on;
using test::left_arm;

constexpr double kError = 1e-4;  // of the whole motion [rad]

struct Planned {
  PathConstraint constraint;
  std::vector<JointVector> waypoints;
};

/// Around a post, so that there are corners.
Planned planned(std::uint64_t seed) {
  Rng rng(seed);
  CollisionWorld world;
  WorldObject post;
  post.name = "post";
  post.shapes.push_back({Box{{0.1, 0.1, 1.0}}, Pose::Identity(), {}});
  post.root_T_object = make_pose({0.75, 0.4, 0.9});
  test::must(world.add(post));
  auto checker = CollisionChecker::make(left_arm(), world).value();
  const auto constraint = constraint_on(left_arm(), {test::level()});
  while (true) {
    const auto start = test::random_level_state(constraint, checker, rng);
    const auto goal = test::random_level_state(constraint, checker, rng);
    const auto result = ConstrainedPlanner(checker, constraint, {}).plan({start, {goal}, {}});
    if (result.code == PlanCode::kSuccess && result.states > 0) return {constraint, result.waypoints};
  }
}

TrajectoryLimits limits(bool jerk) {
  TrajectoryLimits limits{JointVector::Constant(7, 1.5), JointVector::Constant(7, 3.0), {}};
  if (jerk) limits.jerk = JointVector::Constant(7, 100.0);
  return limits;
}

double worst_tilt(const JointTrajectory& trajectory) {
  double worst = 0;
  for (double t = 0; t < trajectory.duration_s(); t += 1e-3)
    worst = std::max(worst, test::tilt_rad(left_arm(), trajectory.sample(t).position));
  return worst;
}

/// Cubic interpolation of two points [rad].
JointVector between(const TrajectoryPoint& a, const TrajectoryPoint& b, double fraction) {
  const double step = b.time_s - a.time_s;
  const double u = 1 - fraction;
  return u * u * (1 + 2 * fraction) * a.position + fraction * fraction * (3 - 2 * fraction) * b.position +
         step * fraction * u * (u * a.velocity - fraction * b.velocity);
}

TEST(ConstrainedMotion, RoundedCornersKeepTheConstraint) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto [constraint, waypoints] = planned(seed);
    const auto corners = corner_deviations(constraint, waypoints, kError).value();
    const auto path = JointPath::make(waypoints, {1.0, corners}).value();
    const auto trajectory = parameterize(path, limits(false)).value();
    EXPECT_EQ(trajectory.runs().size(), 1U) << "a motion without stops";
    EXPECT_LE(worst_tilt(trajectory), kError);
  }
}

TEST(ConstrainedMotion, PointsOfAControllerKeepTheConstraint) {
  const auto [constraint, waypoints] = planned(5);
  PointParams params;
  params.tolerance_rad = 5e-6;
  double steepest = 0;
  for (const auto& waypoint : waypoints) steepest = std::max(steepest, constraint.steepness(waypoint, 0.05));
  const double taken = steepest * std::sqrt(7.0) * params.tolerance_rad;
  const auto corners = corner_deviations(constraint, waypoints, kError - taken).value();
  const auto trajectory =
      parameterize(JointPath::make(waypoints, {1.0, corners}).value(), limits(false)).value();
  const auto points = to_points(trajectory, params).value();
  double worst = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const int steps = 1 + static_cast<int>((points[i].time_s - points[i - 1].time_s) / 1e-3);
    for (int s = 0; s <= steps; ++s) {
      const double fraction = static_cast<double>(s) / steps;
      worst = std::max(worst, test::tilt_rad(left_arm(), between(points[i - 1], points[i], fraction)));
    }
  }
  EXPECT_LE(worst, kError);
}

TEST(ConstrainedMotion, JerkLimitsKeepTheConstraint) {
  const auto [constraint, waypoints] = planned(6);
  TimeParams params;
  params.smoothing_deviation_rad = 1e-5;
  const auto corners =
      corner_deviations(constraint, waypoints, kError, params.smoothing_deviation_rad).value();
  const auto path = JointPath::make(waypoints, {1.0, corners}).value();
  const auto trajectory = parameterize(path, limits(true), params).value();
  EXPECT_LE(worst_tilt(trajectory), kError);
}

TEST(ConstrainedMotion, CornersOfTheWrongSizeAreRefused) {
  const auto constraint = constraint_on(left_arm(), {test::level()});
  const auto refused = [&](const std::vector<JointVector>& waypoints, double error, double smoothing) {
    return !corner_deviations(constraint, waypoints, error, smoothing).has_value();
  };
  const JointVector level = constraint.project(JointVector::Zero(7), left_arm().limits()).value();
  EXPECT_FALSE(refused({level, level}, 1e-4, 0));
  EXPECT_TRUE(refused({level, JointVector::Zero(6)}, 1e-4, 0));
  EXPECT_TRUE(refused({level, JointVector::Constant(7, std::nan(""))}, 1e-4, 0));
  EXPECT_TRUE(refused({level, level}, 0, 0));
  EXPECT_TRUE(refused({level, level}, 1e-4, -1));
  EXPECT_TRUE(refused({level, level}, 1e-4, 1e-3)) << "smoothing takes more than there is";
  EXPECT_TRUE(refused({JointVector::Zero(7), level}, 1e-4, 0)) << "the segment is off the constraint";
}

}  // namespace
}  // namespace extperfc::arm
