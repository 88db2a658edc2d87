// The floor along each ray: ramps belong to it, kerbs and walls do not.
#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"

#include "test/unit/scan/vlp16.hpp"

namespace extperfc::scan {
namespace {
const Pose kSensor = make_pose({0, 0, 0.4});

ScanParams slope_params() {
  auto params = open_params();
  params.min_height = -0.5;
  params.max_height = 1.5;
  params.range_min = 0.6;
  params.range_max = 20;
  params.ground.method = GroundMethod::kSlope;
  params.ground.max_slope_rad = 12 * kDegree;
  return params;
}

/// A ramp 2 m wide that rises ahead from x = `foot`.
Scene ramp(double foot, double slope_rad) {
  const Eigen::Vector3d normal(-std::sin(slope_rad), 0, std::cos(slope_rad));
  const Scene surface = plane(normal, normal.x() * foot);
  return [=](const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
    const double distance = surface(from, direction);
    const Eigen::Vector3d end = from + distance * direction;
    return end.x() >= foot && std::abs(end.y()) <= 1 ? distance : kNothingThere;
  };
}

Outcome see(const Scene& scene, const ScanParams& params = slope_params(), double noise_m = 0.01) {
  Vlp16 lidar;
  lidar.noise_m = noise_m;
  return run(params, revolution(scene, kSensor, lidar), kSensor);
}

TEST(SlopeGround, ALevelFloorIsGround) {
  const auto outcome = see(floor_at(0));
  EXPECT_EQ(hits(outcome.scan), 0U);
  EXPECT_GT(outcome.statistics.on_ground, 10000U);
}

TEST(SlopeGround, ARampOfTenDegreesIsGroundAndItsHeightIsNot) {
  for (const double foot : {1.0, 2.0, 3.0, 4.0}) {
    const Scene scene = all_of({floor_at(0), ramp(foot, 10 * kDegree)});
    EXPECT_EQ(hits(see(scene).scan), 0U) << "foot at " << foot << " m";
    auto by_height = slope_params();
    by_height.ground.method = GroundMethod::kHeight;
    EXPECT_GT(hits(see(scene, by_height).scan), 15U) << "by height the ramp is a wall";
  }
}

TEST(SlopeGround, ASteepRampIsAnObstacle) {
  const auto outcome = see(all_of({floor_at(0), ramp(2.0, 30 * kDegree)}));
  EXPECT_GT(hits(outcome.scan), 40U) << "2 m wide, 2 m away: 53 degrees";
}

TEST(SlopeGround, AKerbIsAnObstacle) {
  for (const double at : {1.5, 2.0, 2.5, 3.0}) {
    const Scene scene = all_of({floor_at(0), box({at, -20, -1}, {at + 5, 20, 0.15})});
    const auto outcome = see(scene);
    for (const int degree : {-20, -10, 0, 10, 20}) {
      const float range = outcome.scan.ranges[ray_at(outcome.scan, degree * kDegree)];
      EXPECT_NEAR(range, at / std::cos(degree * kDegree), 0.35)
          << "kerb at " << at << " m, " << degree << " degrees";
    }
  }
}

TEST(SlopeGround, AWallIsNotClimbedHoweverFineItsPointsLie) {
  std::vector<TestPoint> wall;
  for (int i = 0; i < 400; ++i)
    wall.push_back({2.0F + 1e-4F * static_cast<float>(i), 0, 0.004F * static_cast<float>(i)});
  const auto outcome = run(slope_params(), wall);
  EXPECT_NEAR(outcome.scan.ranges[ray_at(outcome.scan, 0)], 2.0, 0.02);
  // Up to the clearance, and what the floor may have risen to on the way there, belongs to the floor.
  EXPECT_LT(outcome.statistics.on_ground, 60U);
}

TEST(SlopeGround, WhatStandsOnARampIsAnObstacle) {
  const double height = 2.0 * std::tan(10 * kDegree);  // of the ramp 2 m behind its foot
  const Scene scene = all_of(
      {floor_at(0), ramp(1.0, 10 * kDegree), box({3.0, -0.3, height - 0.5}, {3.2, 0.3, height + 0.5})});
  const auto outcome = see(scene);
  EXPECT_NEAR(outcome.scan.ranges[ray_at(outcome.scan, 0)], 3.0, 0.03);
  EXPECT_LT(hits(outcome.scan), 20U) << "the box only";
}

TEST(SlopeGround, TheFloorGoesOnBehindAnObstacle) {
  const Scene scene = all_of({floor_at(0), box({1.9, -20, 0.5}, {2.0, 20, 0.55})});  // a bar over the floor
  const auto outcome = see(scene);
  EXPECT_GT(outcome.statistics.on_ground, 8000U);
  for (const float range : outcome.scan.ranges)
    if (std::isfinite(range)) {
      EXPECT_GT(range, 1.8);
    }
}

TEST(SlopeGround, ADropIsNoObstacle) {
  std::vector<TestPoint> points{{1, 0, 0}, {1.5F, 0, -1.2F}, {2, 0, 0.02F}, {2.5F, 0, 0.3F}};
  const auto outcome = run(slope_params(), points);
  EXPECT_EQ(outcome.statistics.on_ground, 2U + 1U);
  EXPECT_FLOAT_EQ(outcome.scan.ranges[ray_at(outcome.scan, 0)], 2.5F);
}

TEST(SlopeGround, TheHeightBandCountsAsEver) {
  auto params = slope_params();
  params.min_height = 0.2;
  params.max_height = 0.4;
  const auto outcome = run(params, {{1, 0, 0}, {1.01F, 0, 0.15F}, {2, 0, 0.3F}, {3, 0, 0.5F}});
  EXPECT_EQ(outcome.statistics.used, 1U);
  EXPECT_FLOAT_EQ(outcome.scan.ranges[ray_at(outcome.scan, 0)], 2.0F);
}

}  // namespace
}  // namespace extperfc::scan
