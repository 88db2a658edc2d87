#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "mapping/scan_points.hpp"
#include "test/support/planar_world.hpp"

namespace extperfc::mapping {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Half a turn to the front, a ray per degree.
PlanarScanner front_scanner(double sigma_m = 0) {
  PlanarScanner scanner;
  scanner.rays = 181;
  scanner.angle_min = -M_PI / 2;
  scanner.angle_increment = M_PI / 180;
  scanner.sigma_m = sigma_m;
  return scanner;
}

/// A wall 3 m ahead, 4 m wide.
PlanarWorld wall_ahead() {
  PlanarWorld world;
  world.add_wall({3, -2}, {3, 2});
  return world;
}

float angle_between(const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
  return std::abs(std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)));
}

TEST(ScanPoints, NormalsOfAWallFaceTheScanner) {
  Rng rng(1);
  const auto points = scan_points(front_scanner().scan(wall_ahead(), {}, rng), {});
  ASSERT_GT(points.surface.size(), 60U);
  for (const auto& point : points.surface) {
    EXPECT_NEAR(point.position.x(), 3, 1e-5);
    ASSERT_TRUE(point.has_normal());
    EXPECT_NEAR(point.normal.norm(), 1, 1e-5);
    EXPECT_LT(angle_between(point.normal, {-1, 0}), 1e-3F);
  }
}

TEST(ScanPoints, NormalsOfANoisyWall) {
  Rng rng(2);
  constexpr double kSigmaM = 0.01;
  int all = 0;
  int within = 0;
  for (int k = 0; k < 50; ++k) {
    const auto points = scan_points(front_scanner(kSigmaM).scan(wall_ahead(), {}, rng), {});
    for (const auto& point : points.surface) {
      ++all;
      // At least 4 neighbours d apart on either side, d >= 3 m / 57, lie within reach: the slope of a line
      // through 5 of them (at the wall's end) has the standard deviation sigma / (d sqrt(10)) = 0.06 rad.
      constexpr float kBoundRad = 3 * 0.06F;
      if (!point.has_normal()) continue;
      EXPECT_LT(point.normal.dot(point.position), 0) << "it faces the scanner";
      EXPECT_NEAR(point.normal.norm(), 1, 1e-5);
      if (angle_between(point.normal, {-1, 0}) < kBoundRad) ++within;
    }
  }
  EXPECT_GT(within, 0.97 * all);
}

TEST(ScanPoints, CornersHaveNoNormal) {
  PlanarWorld world;
  world.add_wall({-2, 2}, {2, 2});
  world.add_wall({2, -2}, {2, 2});
  Rng rng(3);
  PlanarScanner scanner = front_scanner();
  scanner.angle_min = 0;
  scanner.rays = 91;  // the corner is at 45 degrees
  const auto points = scan_points(scanner.scan(world, {}, rng), {});
  int corner = 0;
  for (const auto& point : points.surface) {
    const float away = (point.position - Eigen::Vector2f(2, 2)).norm();
    if (away < 0.1F) {
      ++corner;
      EXPECT_FALSE(point.has_normal()) << away;
    } else if (away > 0.4F) {
      const bool right = point.position.x() > 1.999F;
      EXPECT_LT(angle_between(point.normal, right ? Eigen::Vector2f(-1, 0) : Eigen::Vector2f(0, -1)), 1e-3F);
    }
  }
  EXPECT_GE(corner, 2);
}

TEST(ScanPoints, ALonePointHasNoNormal) {
  LaserScan scan;
  scan.angle_increment = 0.01;
  scan.range_min = 0.1;
  scan.range_max = 10;
  scan.ranges.assign(100, kInfinity);
  scan.ranges[10] = 2;
  scan.ranges[60] = 3;
  scan.ranges[61] = 5;  // neighbours, but not of one surface
  const auto points = scan_points(scan, {});
  ASSERT_EQ(points.surface.size(), 3U);
  for (const auto& point : points.surface) EXPECT_FALSE(point.has_normal());
  EXPECT_TRUE(points.clear.empty());
}

TEST(ScanPoints, DenseScansAreThinned) {
  PlanarWorld world;
  world.add_box(-0.6, -0.6, 0.6, 0.6);
  PlanarScanner scanner;
  scanner.rays = 3600;
  scanner.angle_increment = 2 * M_PI / 3600;
  scanner.sigma_m = 0;
  Rng rng(4);
  const auto points = scan_points(scanner.scan(world, {}, rng), {});
  // 4.8 m of wall, a point every 3 cm.
  EXPECT_LE(points.surface.size(), 165U);
  EXPECT_GE(points.surface.size(), 100U);
  for (std::size_t i = 1; i < points.surface.size(); ++i)
    EXPECT_GE((points.surface[i].position - points.surface[i - 1].position).norm(), 0.0299F);
}

TEST(ScanPoints, NumbersAreBounded) {
  PlanarWorld world;
  world.add_box(-10, -10, 10, 10);
  PlanarScanner scanner;
  scanner.rays = 50000;
  scanner.angle_increment = 2 * M_PI / 50000;
  scanner.range_max = 30;
  Rng rng(5);
  const auto scan = scanner.scan(world, {}, rng);
  const auto points = scan_points(scan, {});
  EXPECT_LE(points.surface.size(), 400U);
  EXPECT_GE(points.surface.size(), 200U);
  int of_wall[4] = {};
  for (const auto& point : points.surface) {
    const auto& p = point.position;
    ++of_wall[std::abs(p.x()) > std::abs(p.y()) ? (p.x() > 0 ? 0 : 1) : (p.y() > 0 ? 2 : 3)];
  }
  for (const int count : of_wall) EXPECT_NEAR(count, static_cast<double>(points.surface.size()) / 4, 12);
  auto open = scan;
  std::fill(open.ranges.begin(), open.ranges.end(), kInfinity);
  const auto clear = scan_points(open, {0, 8});
  EXPECT_TRUE(clear.surface.empty());
  EXPECT_LE(clear.clear.size(), 120U);
  EXPECT_GE(clear.clear.size(), 60U);
}

/// Rays a degree apart with the given ranges, lawful ones in [0.5, 10].
LaserScan scan_with(std::vector<float> ranges) {
  LaserScan scan;
  scan.angle_increment = M_PI / 180;
  scan.range_min = 0.5;
  scan.range_max = 10;
  scan.ranges = std::move(ranges);
  return scan;
}

TEST(ScanPoints, WhatSaysNothing) {
  const auto scan = scan_with({std::numeric_limits<float>::quiet_NaN(), 0, -1, -kInfinity, 0.49F, 1e-30F});
  for (const double max_range_m : {0.0, 5.0}) {
    const auto points = scan_points(scan, {0, max_range_m});
    EXPECT_TRUE(points.surface.empty());
    EXPECT_TRUE(points.clear.empty()) << "an unusable range never says that the way is free";
  }
}

TEST(ScanPoints, ClearRaysOnlyWithMaxRange) {
  const auto scan = scan_with({kInfinity, 10.5F, std::numeric_limits<float>::max()});
  EXPECT_TRUE(scan_points(scan, {}).clear.empty());
  const auto to_five = scan_points(scan, {0, 5});
  EXPECT_TRUE(to_five.surface.empty());
  ASSERT_EQ(to_five.clear.size(), 3U);
  for (const auto& end : to_five.clear) EXPECT_NEAR(end.norm(), 5, 1e-5);
  const auto beyond_range = scan_points(scan, {0, 50});
  for (const auto& end : beyond_range.clear) EXPECT_NEAR(end.norm(), 10, 1e-5) << "no farther than it sees";
  const auto usable = scan_points(scan, {3, 5});
  for (const auto& end : usable.clear) EXPECT_NEAR(end.norm(), 3, 1e-5) << "no farther than what counts";
}

TEST(ScanPoints, ReturnsBeyondMaxUrangeDoNotCount) {
  const auto points = scan_points(scan_with({2, 4, 6, 10, 10.1F}), {4, 0});
  ASSERT_EQ(points.surface.size(), 2U);
  EXPECT_NEAR(points.surface[0].position.norm(), 2, 1e-5);
  EXPECT_NEAR(points.surface[1].position.norm(), 4, 1e-5);
  ASSERT_EQ(points.clear.size(), 2U) << "they met something farther away, so the way there is free";
  for (const auto& end : points.clear) EXPECT_NEAR(end.norm(), 4, 1e-5);
  EXPECT_EQ(scan_points(scan_with({2, 4, 6, 10}), {50, 0}).surface.size(), 4U) << "range_max bounds it";
}

TEST(ScanPoints, MountedScanner) {
  PlanarScanner scanner = front_scanner();
  scanner.base_T_sensor = {0.3, -0.2, 0};
  Rng rng(6);
  const auto ahead = scan_points(scanner.scan(wall_ahead(), {}, rng), {});
  EXPECT_NEAR(ahead.scanner.x(), 0.3, 1e-6);
  EXPECT_NEAR(ahead.scanner.y(), -0.2, 1e-6);
  ASSERT_FALSE(ahead.surface.empty());
  for (const auto& point : ahead.surface) EXPECT_NEAR(point.position.x(), 3, 1e-5);
  // Looking backwards from the robot's rear: the same wall behind.
  scanner.base_T_sensor = {-0.3, 0.1, M_PI};
  const auto behind = scan_points(scanner.scan(wall_ahead(), {0, 0, M_PI}, rng), {0, 2});
  ASSERT_FALSE(behind.surface.empty());
  for (const auto& point : behind.surface) {
    EXPECT_NEAR(point.position.x(), -3, 1e-4);
    EXPECT_LT(angle_between(point.normal, {1, 0}), 1e-3F);
  }
  for (const auto& end : behind.clear) EXPECT_NEAR((end - behind.scanner).norm(), 2, 1e-4);
}

TEST(ScanPoints, UpsideDown) {
  Rng rng(7);
  const auto upright = front_scanner().scan(wall_ahead(), {0, 0.4, 0.2}, rng);
  LaserScan hanging = upright;
  hanging.angle_min = upright.angle_min + 180 * upright.angle_increment;
  hanging.angle_increment = -upright.angle_increment;
  std::reverse(hanging.ranges.begin(), hanging.ranges.end());
  const auto a = scan_points(upright, {});
  auto b = scan_points(hanging, {});
  std::reverse(b.surface.begin(), b.surface.end());
  ASSERT_EQ(a.surface.size(), b.surface.size());  // rays are too far apart to be thinned
  ASSERT_GT(a.surface.size(), 50U);
  for (std::size_t i = 0; i < a.surface.size(); ++i) {
    EXPECT_LT((a.surface[i].position - b.surface[i].position).norm(), 1e-5F);
    EXPECT_LT((a.surface[i].normal - b.surface[i].normal).norm(), 1e-3F);
  }
}

TEST(ScanPoints, FarAwayNumbersStayFinite) {
  auto scan = scan_with(std::vector<float>(30, 3e21F));
  scan.range_max = 1e22;
  for (float& range : scan.ranges) range *= 1 + 1e-3F * static_cast<float>(&range - scan.ranges.data());
  const auto points = scan_points(scan, {});
  for (const auto& point : points.surface) {
    EXPECT_TRUE(point.position.allFinite());
    EXPECT_TRUE(point.normal.allFinite());
  }
}

}  // namespace
}  // namespace extperfc::mapping
