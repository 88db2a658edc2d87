#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/collision_guard.hpp"

#include "test/support/building.hpp"
#include "test/support/drive_simulation.hpp"

namespace extperfc::navigate {
namespace {

using Points = std::vector<Eigen::Vector2d>;

/// By small steps: the first time at which the moved footprint holds a point.
double stepped_time(const Points& points, const Footprint& footprint, const Twist2& twist, double horizon_s) {
  constexpr double kStep_s = 5e-4;
  for (double time_s = 0; time_s <= horizon_s; time_s += kStep_s) {
    const auto body = placed(footprint.corners_m(), advance({}, twist, time_s));
    if (std::any_of(points.begin(), points.end(),
                    [&](const Eigen::Vector2d& point) { return polygon_distance(body, point) <= 0; }))
      return time_s;
  }
  return INFINITY;
}

TEST(TimeToContact, IsThatOfSmallSteps) {
  Rng rng(3);
  const Footprint footprint = chassis();
  int hits = 0;
  for (int i = 0; i < 150; ++i) {
    const Eigen::Vector2d point(rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5));
    if (polygon_distance(footprint.corners_m(), point) < 0.02) continue;
    const Twist2 twist{rng.uniform(-1, 1), rng.uniform(-0.6, 0.6),
                       rng.chance(0.3) ? 0 : rng.uniform(-1.5, 1.5)};
    const double expected = stepped_time({point}, footprint, twist, 2);
    const auto time_s = time_to_contact({point}, footprint, 0, twist, 2);
    if (std::isfinite(expected)) {
      ++hits;
      ASSERT_TRUE(time_s) << i;
      EXPECT_NEAR(*time_s, expected, 2e-3) << i;
    } else if (time_s) {  // a corner is grazed
      EXPECT_GT(*time_s, 0) << i;
      EXPECT_TRUE(std::isfinite(stepped_time({point}, footprint.padded(0.002), twist, 2))) << i;
    }
  }
  EXPECT_GT(hits, 10);
}

TEST(TimeToContact, StraightAheadIsDistanceBySpeed) {
  const auto time_s = time_to_contact({{1.0, 0}}, chassis(), 0.1, {0.5, 0, 0}, 5);
  ASSERT_TRUE(time_s);
  EXPECT_NEAR(*time_s, (1.0 - 0.4064 - 0.1) / 0.5, 1e-9);
  EXPECT_FALSE(time_to_contact({{1.0, 0}}, chassis(), 0.1, {-0.5, 0, 0}, 5));
}

/// A scan of half a degree per ray, from -pi.
LaserScan blank_scan() {
  LaserScan scan;
  scan.angle_min = -kPi;
  scan.angle_increment = kPi / 360;
  scan.range_min = 0.4;
  scan.range_max = 30;
  scan.ranges.assign(720, std::numeric_limits<float>::infinity());
  return scan;
}

TEST(SurfacePoints, NoiseOfANearWallBringsItNoNearer) {
  Rng rng(5);
  constexpr double kWall_m = 0.45;
  constexpr double kSigma_m = 0.01;
  double nearest_m = 1;
  double nearest_raw_m = 1;
  for (int sweep = 0; sweep < 50; ++sweep) {
    LaserScan scan = blank_scan();
    for (std::size_t i = 420; i < 660; ++i) {
      const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
      const double range_m = kWall_m / std::sin(angle) + rng.normal(0, kSigma_m);
      scan.ranges[i] = static_cast<float>(range_m);
      nearest_raw_m = std::min(nearest_raw_m, range_m * std::sin(angle));
    }
    for (const auto& point : surface_points(scan)) nearest_m = std::min(nearest_m, point.y());
  }
  EXPECT_LT(nearest_raw_m, kWall_m - 3 * kSigma_m);
  EXPECT_GT(nearest_m, kWall_m - 2.5 * kSigma_m);  // of 12,000 medians of five
}

TEST(SurfacePoints, ANarrowPostStays) {
  for (const std::size_t width : {1U, 2U, 3U}) {
    LaserScan scan = blank_scan();
    for (std::size_t i = 100; i < 500; ++i) scan.ranges[i] = 0.9F;  // a wall behind it
    for (std::size_t i = 0; i < width; ++i) scan.ranges[360 + i] = 0.5F;
    double nearest_m = 1;
    for (const auto& point : surface_points(scan)) nearest_m = std::min(nearest_m, point.norm());
    EXPECT_NEAR(nearest_m, 0.5, 1e-6) << width << " rays";
  }
}

TEST(SurfacePoints, FarRangesAndTheFirstAndLastRayAreAsTheyWere) {
  LaserScan scan = blank_scan();
  scan.ranges[0] = scan.ranges[719] = 0.6F;
  scan.ranges[360] = 2.0F;
  scan.ranges[361] = 2.05F;
  scan.ranges[362] = std::numeric_limits<float>::quiet_NaN();
  scan.ranges[363] = 0.2F;  // below range_min
  const auto points = surface_points(scan);
  ASSERT_EQ(points.size(), 4U);
  EXPECT_NEAR(points[0].norm(), 0.6, 1e-6);
  EXPECT_NEAR(points[1].norm(), 2.0, 1e-6);
  EXPECT_NEAR(points[2].norm(), 2.05, 1e-6);
  EXPECT_NEAR(points[3].norm(), 0.6, 1e-6);
  scan.base_T_sensor = {0.3, -0.1, kPi / 2};
  EXPECT_NEAR(surface_points(scan)[1].x(), 0.3, 1e-6);
  EXPECT_NEAR(surface_points(scan)[1].y(), 1.9, 1e-6);
}

TEST(CollisionGuard, PassesWhatIsFree) {
  CollisionGuard guard({});
  guard.set_points({{3, 0}, {0, 2}}, 10);
  const GuardedCommand result = guard.admit(chassis(), {}, {0.8, 0, 0}, 10.1);
  EXPECT_EQ(result.action, GuardAction::kPassed);
  EXPECT_EQ(result.velocity.vx, 0.8);
  EXPECT_TRUE(result.reason.empty());
}

TEST(CollisionGuard, SlowsAlongTheSameArcAndStops) {
  CollisionGuard guard({});
  guard.set_points({{0.7, 0}}, 10);
  const GuardedCommand slowed = guard.admit(chassis(), {}, {0.8, 0.1, 0.2}, 10);
  EXPECT_EQ(slowed.action, GuardAction::kSlowed);
  EXPECT_LT(slowed.velocity.vx, 0.8);
  EXPECT_GT(slowed.velocity.vx, 0);
  EXPECT_NEAR(slowed.velocity.vy / slowed.velocity.vx, 0.1 / 0.8, 1e-9);
  EXPECT_NEAR(slowed.velocity.wz / slowed.velocity.vx, 0.2 / 0.8, 1e-9);
  ASSERT_TRUE(slowed.time_s);
  guard.set_points({{0.43, 0}}, 10);
  const GuardedCommand stopped = guard.admit(chassis(), {}, {0.8, 0, 0}, 10);
  EXPECT_EQ(stopped.action, GuardAction::kStopped);
  EXPECT_EQ(stopped.velocity.vx, 0);
  EXPECT_FALSE(stopped.reason.empty());
}

TEST(CollisionGuard, LetsTheBaseAwayFromAContact) {
  CollisionGuard guard({});
  guard.set_points({{0.39, 0}}, 10);  // inside the chassis, at its front
  EXPECT_EQ(guard.admit(chassis(), {}, {0.3, 0, 0}, 10).action, GuardAction::kStopped);
  const GuardedCommand back = guard.admit(chassis(), {}, {-0.3, 0, 0}, 10);
  EXPECT_EQ(back.action, GuardAction::kPassed);
  EXPECT_EQ(back.velocity.vx, -0.3);
  EXPECT_EQ(guard.admit(chassis(), {}, {0, 0.3, 0}, 10).action, GuardAction::kPassed);
}

TEST(CollisionGuard, PassesADoorThatIsBarelyWideEnough) {
  CollisionGuard guard({});
  Points posts;
  for (const double side : {-0.405, 0.405})
    for (int i = 0; i < 10; ++i) posts.emplace_back(-0.1 + 0.02 * i, side);
  guard.set_points(posts, 10);
  EXPECT_EQ(guard.admit(chassis(), {}, {0.3, 0, 0}, 10).action, GuardAction::kPassed);
  EXPECT_NE(guard.admit(chassis(), {}, {0.3, 0, 0.5}, 10).action, GuardAction::kPassed);
}

TEST(CollisionGuard, StopsWithoutALatestScan) {
  CollisionGuard guard({});
  EXPECT_EQ(guard.admit(chassis(), {}, {0.3, 0, 0}, 10).action, GuardAction::kNoScan);
  guard.set_points({}, 10);
  EXPECT_EQ(guard.admit(chassis(), {}, {0.3, 0, 0}, 10.3).action, GuardAction::kPassed);
  const GuardedCommand old = guard.admit(chassis(), {}, {0.3, 0, 0}, 10.5);
  EXPECT_EQ(old.action, GuardAction::kNoScan);
  EXPECT_EQ(old.velocity.vx, 0);
  EXPECT_FALSE(old.reason.empty());
  EXPECT_EQ(guard.admit(chassis(), {}, {0.3, 0, 0}, 3).action, GuardAction::kNoScan);  // clocks jumped
  EXPECT_EQ(guard.admit(chassis(), {}, {}, 99).action, GuardAction::kPassed);  // a stop is always free
}

TEST(CollisionGuard, PointsMoveWithTheBase) {
  CollisionGuard guard({});
  guard.set_points({{1.0, 0}}, 10);
  const auto still = guard.admit(chassis(), {}, {0.8, 0, 0}, 10.2);
  const auto moving = guard.admit(chassis(), {0.8, 0, 0}, {0.8, 0, 0}, 10.2);
  ASSERT_TRUE(still.time_s);
  ASSERT_TRUE(moving.time_s);
  EXPECT_NEAR(*still.time_s - *moving.time_s, 0.2, 1e-9);
}

TEST(CollisionGuard, ABaseNeverTouchesUnderRandomCommands) {
  const Footprint footprint = chassis();
  Rng rng(4);
  for (int trial = 0; trial < 20; ++trial) {
    CollisionGuard guard({});
    Points world;
    for (int i = 0; i < 200; ++i) {
      const double angle = rng.uniform(-M_PI, M_PI);
      const double range = rng.uniform(0.75, 1.6);
      world.emplace_back(range * std::cos(angle), range * std::sin(angle));
    }
    Pose2 pose;
    Twist2 velocity;
    Twist2 wanted;
    const VelocityLimits base{0.8, -0.8, 0.8, 1.2, 1.0, 1.0, 2.5};
    for (int step = 0; step < 400; ++step) {
      if (step % 20 == 0) wanted = {rng.uniform(-0.8, 0.8), rng.uniform(-0.8, 0.8), rng.uniform(-1.2, 1.2)};
      Points seen;
      seen.reserve(world.size());
      for (const Eigen::Vector2d& point : world) {
        const Pose2 at = between(pose, {point.x(), point.y(), 0});
        seen.emplace_back(at.x, at.y);
      }
      guard.set_points(seen, 0.02 * step);
      const Twist2 sent = guard.admit(footprint, velocity, wanted, 0.02 * step).velocity;
      velocity = limited_change(sent, velocity, base, 0.02);
      pose = advance(pose, velocity, 0.02);
      const auto body = placed(footprint.corners_m(), pose);
      for (const Eigen::Vector2d& point : world)
        ASSERT_GT(polygon_distance(body, point), 0) << "trial " << trial << " step " << step;
    }
  }
}

TEST(CollisionGuard, RefusesParametersOutOfTheirRange) {
  EXPECT_THROW(CollisionGuard({0, 0, 1, 2}), std::invalid_argument);
  EXPECT_THROW(CollisionGuard({0.5, -1, 1, 2}), std::invalid_argument);
  EXPECT_THROW(CollisionGuard({0.5, 0, 1, 0.1}), std::invalid_argument);
  CollisionGuard guard({});
  guard.set_points({{NAN, 0}}, 0);
  EXPECT_EQ(guard.admit(chassis(), {}, {NAN, 0, 0}, 0).action, GuardAction::kStopped);
}

}  // namespace
}  // namespace extperfc::navigate
