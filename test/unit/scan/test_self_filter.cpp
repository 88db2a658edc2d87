// The robot's own points: volumes, poses, and what they do to a scan.
#include <gtest/gtest.h>

#include "test/unit/scan/vlp16.hpp"

namespace extperfc::scan {
namespace {

SelfVolume capsule(const std::string& frame, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                   double radius) {
  SelfVolume volume;
  volume.frame = frame;
  volume.capsule = Capsule{from, to, radius};
  return volume;
}

SelfVolume cuboid(const std::string& frame, const Pose& pose, const Eigen::Vector3d& size) {
  SelfVolume volume;
  volume.frame = frame;
  volume.box = Cuboid{pose, size};
  return volume;
}

bool contains(const SelfFilter& filter, const Eigen::Vector3d& point) {
  return filter.contains(point.cast<float>());
}

TEST(SelfFilter, ACapsuleHasRoundEnds) {
  auto filter = *SelfFilter::make({capsule("arm", {0, 0, 0}, {0.4, 0, 0}, 0.1)}, 0.0);
  EXPECT_EQ(filter.frames(), std::vector<std::string>{"arm"});
  filter.place({make_pose({1, 0, 0}, {0, 0, M_PI / 2})});  // from (1, 0, 0) to (1, 0.4, 0)
  for (const Eigen::Vector3d& inside :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(1.09, 0.2, 0), Eigen::Vector3d(1, 0.49, 0),
        Eigen::Vector3d(1, -0.09, 0), Eigen::Vector3d(1, 0.2, -0.09)})
    EXPECT_TRUE(contains(filter, inside)) << inside.transpose();
  for (const Eigen::Vector3d& outside :
       {Eigen::Vector3d(1.11, 0.2, 0), Eigen::Vector3d(1, 0.51, 0), Eigen::Vector3d(1.08, 0.48, 0),
        Eigen::Vector3d(1, -0.11, 0), Eigen::Vector3d(0, 0, 0)})
    EXPECT_FALSE(contains(filter, outside)) << outside.transpose();
}

TEST(SelfFilter, ABoxIsPaddedOnEverySide) {
  auto filter = *SelfFilter::make({cuboid("body", make_pose({0, 0, 1}), {0.4, 0.2, 0.6})}, 0.05);
  filter.place({Pose::Identity()});
  EXPECT_TRUE(contains(filter, {0.24, 0, 1}));
  EXPECT_FALSE(contains(filter, {0.26, 0, 1}));
  EXPECT_TRUE(contains(filter, {0, 0.14, 1.34}) == (std::hypot(0.04, 0.04) <= 0.05));
  EXPECT_TRUE(contains(filter, {0, 0, 0.66}));
  EXPECT_FALSE(contains(filter, {0, 0, 0.64}));
}

TEST(SelfFilter, WithoutAPoseAVolumeDoesNotCount) {
  auto filter =
      *SelfFilter::make({capsule("a", {0, 0, 0}, {0, 0, 0}, 0.5), capsule("b", {0, 0, 0}, {0, 0, 0}, 0.5),
                         capsule("a", {0, 2, 0}, {0, 2, 0}, 0.5)},
                        0.0);
  EXPECT_EQ(filter.frames(), (std::vector<std::string>{"a", "b"}));
  EXPECT_FALSE(contains(filter, {0, 0, 0})) << "nothing is placed yet";
  filter.place({make_pose({1, 0, 0}), std::nullopt});
  EXPECT_TRUE(contains(filter, {1, 0, 0}));
  EXPECT_TRUE(contains(filter, {1, 2, 0}));
  EXPECT_FALSE(contains(filter, {0, 0, 0}));
  filter.place({std::nullopt, Pose::Identity()});
  EXPECT_TRUE(contains(filter, {0, 0, 0}));
  EXPECT_FALSE(contains(filter, {1, 2, 0}));
  EXPECT_FALSE(filter.contains(Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN())));
}

TEST(SelfFilter, WhatCannotBeIsNamed) {
  const SelfVolume neither{"arm", std::nullopt, std::nullopt};
  auto both = capsule("arm", {0, 0, 0}, {0, 0, 1}, 0.1);
  both.box.emplace();
  for (const auto& volume :
       {neither, both, capsule("", {0, 0, 0}, {0, 0, 1}, 0.1), capsule("arm", {0, 0, 0}, {0, 0, 1}, 0),
        capsule("arm", {0, 0, 0}, {0, 0, 9}, 0.1), cuboid("arm", Pose::Identity(), {1, 1, 0}),
        capsule("arm", {0, 0, 0}, {0, 0, std::nan("")}, 0.1)}) {
    const auto refused = SelfFilter::make({capsule("ok", {0, 0, 0}, {0, 0, 1}, 0.1), volume}, 0);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("volume 1"), std::string::npos) << refused.error().message;
  }
  EXPECT_FALSE(SelfFilter::make({}, -1));
}

/// Law: a capsule is the set of points whose distance from its line is no more than its radius, wherever its
/// frame is; a rigid motion of frame and point together changes nothing.
TEST(SelfFilterProperty, InsideMeansNearTheLine) {
  Rng rng(5);
  const auto vector = [&](double size) {
    return Eigen::Vector3d(rng.uniform(-size, size), rng.uniform(-size, size), rng.uniform(-size, size));
  };
  int inside = 0;
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector3d from = vector(0.5);
    const Eigen::Vector3d to = vector(0.5);
    const double radius = rng.uniform(0.05, 0.4);
    const Eigen::Vector3d point = vector(0.8);
    const double ratio = std::clamp((point - from).dot(to - from) / (to - from).squaredNorm(), 0.0, 1.0);
    const double distance = (point - from - ratio * (to - from)).norm();
    if (std::abs(distance - radius) < 1e-4) continue;
    auto filter = *SelfFilter::make({capsule("arm", from, to, radius)}, 0.0);
    const Pose pose = make_pose(vector(2), vector(3));
    filter.place({pose});
    ASSERT_EQ(contains(filter, pose * point), distance < radius) << i;
    inside += distance < radius ? 1 : 0;
  }
  EXPECT_GT(inside, 100);
}

TEST(SelfFilter, AnArmBeforeTheSensorIsNoObstacle) {
  const Pose base_T_sensor = make_pose({0, 0, 0.4});
  // A forearm that reaches down, 0.8 m before the sensor, and a wall at 3 m.
  const Scene scene =
      all_of({box({0.75, -0.05, 0.2}, {0.85, 0.05, 1.2}), plane(Eigen::Vector3d::UnitX(), 3)});
  const auto points = revolution(scene, base_T_sensor);
  auto params = open_params();
  params.min_height = 0.1;
  params.max_height = 1.5;
  params.range_min = 0.6;
  auto filter = *SelfFilter::make({capsule("arm", {0.8, 0, 0.2}, {0.8, 0, 1.2}, 0.08)}, 0.02);
  filter.place({base_T_sensor.inverse()});
  const auto before = run_both(params, points, base_T_sensor);
  const auto after = run_both(params, points, base_T_sensor, filter);
  const auto ahead = ray_at(before.scans.nearest, 0);
  EXPECT_NEAR(before.scans.supported.ranges[ahead], 0.75, 0.01);
  EXPECT_GT(after.statistics.on_robot, 50U);
  for (const auto* scan : {&after.scans.supported, &after.scans.nearest}) {
    EXPECT_TRUE(std::isnan(scan->ranges[ahead])) << "what the arm hides is unknown, not free";
    EXPECT_NEAR(scan->ranges[ray_at(*scan, 0.3)], 3 / std::cos(0.3), 0.03);
  }
}

}  // namespace
}  // namespace extperfc::scan
