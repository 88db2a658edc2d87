// The floor is removed, what stands on it stays.
#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"

#include "test/unit/scan/cloud_builder.hpp"

namespace extperfc::scan {
namespace {

/// A floor that rises by `slope_rad` along x, 12 m around the sensor, and posts 5 m away that stand on it
/// from 0.1 to 1 m.
std::vector<TestPoint> floor_with_posts(double slope_rad, double noise_m, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<TestPoint> points;
  const auto add = [&](double x, double y, double height) {
    points.push_back({static_cast<float>(x), static_cast<float>(y),
                      static_cast<float>(height + std::tan(slope_rad) * x + rng.normal(0, noise_m))});
  };
  for (int i = 0; i < 8000; ++i) {
    const double angle = rng.uniform(-M_PI, M_PI);
    const double range = rng.uniform(1.0, 12.0);
    add(range * std::cos(angle), range * std::sin(angle), 0);
  }
  for (int post = 0; post < 8; ++post)
    for (int i = 0; i < 20; ++i)
      add(5 * std::cos(post * M_PI / 4), 5 * std::sin(post * M_PI / 4), 0.1 + 0.045 * i);
  return points;
}

ScanParams params_with(GroundMethod method) {
  auto params = open_params();
  params.min_height = -2;
  params.max_height = 2;
  params.ground.method = method;
  params.ground.clearance_m = 0.06;
  return params;
}

void expect_posts_only(const PlanarScan& scan) {
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const auto degree = static_cast<int>(i) - 180;
    if (degree % 45 == 0) {
      EXPECT_NEAR(scan.ranges[i], 5.0, 0.01) << degree;
    } else {
      EXPECT_FALSE(std::isfinite(scan.ranges[i]))
          << degree << " degrees: floor at " << scan.ranges[i] << " m";
    }
  }
}

TEST(Ground, PlaneFollowsASlopeOfThreeDegrees) {
  for (const double degrees : {-3.0, 0.0, 3.0}) {
    const auto [scan, statistics] =
        run(params_with(GroundMethod::kPlane), floor_with_posts(degrees * kDegree, 0.01, 7));
    EXPECT_TRUE(statistics.ground_found);
    EXPECT_NEAR(statistics.ground.slope_rad(), std::abs(degrees) * kDegree, 0.003);
    EXPECT_EQ(statistics.on_ground, 8000U);
    expect_posts_only(scan);
  }
}

TEST(Ground, WithoutRemovalTheFloorIsAnObstacle) {
  const auto [scan, statistics] = run(params_with(GroundMethod::kNone), floor_with_posts(0, 0, 7));
  EXPECT_EQ(statistics.on_ground, 0U);
  EXPECT_EQ(hits(scan), 360U);
}

TEST(Ground, HeightTakesTheFloorForLevel) {
  const auto level = run(params_with(GroundMethod::kHeight), floor_with_posts(0, 0.01, 7));
  expect_posts_only(level.scan);
  EXPECT_EQ(level.statistics.on_ground, 8000U);
  const auto slope = run(params_with(GroundMethod::kHeight), floor_with_posts(3 * kDegree, 0.01, 7));
  EXPECT_GT(hits(slope.scan), 100U) << "the rising half of the floor stands in the way";
}

TEST(Ground, FloorsHeightCounts) {
  auto params = params_with(GroundMethod::kHeight);
  params.ground.z_m = -0.8;
  const Pose target_T_cloud = make_pose({0, 0, -0.8});
  expect_posts_only(run(params, floor_with_posts(0, 0.01, 7), target_T_cloud).scan);
  params.ground.method = GroundMethod::kPlane;
  expect_posts_only(run(params, floor_with_posts(3 * kDegree, 0.01, 7), target_T_cloud).scan);
}

TEST(Ground, SteeperPlanesAreNoFloor) {
  auto params = params_with(GroundMethod::kPlane);
  params.ground.max_slope_rad = 5 * kDegree;
  params.ground.band_m = 2;
  const auto ramp = floor_with_posts(12 * kDegree, 0.0, 7);
  const auto [scan, statistics] = run(params, ramp);
  EXPECT_LE(statistics.ground.slope_rad(), 5 * kDegree);
  EXPECT_GT(hits(scan), 150U) << "the rising half of the ramp is an obstacle";
}

TEST(Ground, WithoutEnoughPointsTheFloorIsLevelAndItIsSaid) {
  const std::vector<TestPoint> few{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {3, 0, 0.5F}};
  const auto [scan, statistics] = run(params_with(GroundMethod::kPlane), few);
  EXPECT_FALSE(statistics.ground_found);
  EXPECT_EQ(statistics.on_ground, 3U);
  EXPECT_EQ(statistics.used, 1U);
}

TEST(Ground, PointsOnALineGiveNoPlane) {
  std::vector<TestPoint> line;
  for (int i = 0; i < 500; ++i) line.push_back({0.01F * static_cast<float>(i), 0, 0});
  const auto [scan, statistics] = run(params_with(GroundMethod::kPlane), line);
  EXPECT_FALSE(statistics.ground_found);
}

TEST(Ground, PointsBelowTheFloorAreNoObstacles) {
  auto points = floor_with_posts(0, 0.005, 7);
  points.push_back({2, 0, -0.5F});  // a reflection
  expect_posts_only(run(params_with(GroundMethod::kPlane), points).scan);
}

TEST(Ground, SameSeedSamePlane) {
  const auto points = floor_with_posts(2 * kDegree, 0.02, 3);
  auto params = params_with(GroundMethod::kPlane);
  const auto first = run(params, points).statistics.ground;
  const auto again = run(params, points).statistics.ground;
  EXPECT_EQ(first.normal, again.normal);
  EXPECT_EQ(first.offset, again.offset);
  for (params.ground.seed = 2; params.ground.seed < 12; ++params.ground.seed)
    EXPECT_NEAR(run(params, points).statistics.ground.slope_rad(), 2 * kDegree, 0.005)
        << "seed " << params.ground.seed;
}

}  // namespace
}  // namespace extperfc::scan
