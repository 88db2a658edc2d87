// Points of one object: nothing of the wall behind it, the table under it, and what stands beside it.
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "extperfc/depth/object_cloud.hpp"

#include "test/unit/depth/standing_object.hpp"

namespace extperfc::depth {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr double kWallM = 2.0;

CameraModel small_camera() {
  return {kWidth, kHeight, 150.0, 150.0, 79.5, 59.5, {}};
}

/// A square of 40 x 40 pixels at 1 m before a wall, in a box of 60 x 60.
class BeforeAWall : public testing::TestWithParam<PixelFormat> {
 protected:
  static constexpr Box2 kBox{50, 30, 110, 90};
  static bool in_square(int x, int y) { return x >= 60 && x < 100 && y >= 40 && y < 80; }
  DepthImage depth_ = DepthImage(kWidth, kHeight, GetParam(), 6, 1).fill([](int x, int y) {
    return in_square(x, y) ? 1.0 : kWallM;
  });
};

TEST_P(BeforeAWall, TheWallIsRemoved) {
  const auto cloud = object_cloud(depth_.view(), small_camera(), kBox, {});
  ASSERT_TRUE(cloud) << cloud.error().message;
  ASSERT_EQ(cloud->points.size(), 1600U);
  EXPECT_EQ(cloud->background_px, 2000);
  EXPECT_EQ(cloud->support_px, 0);
  const Eigen::Vector3d corner = small_camera().back_project(60, 40, 1.0);
  EXPECT_TRUE(cloud->points.front().cast<double>().isApprox(corner, 1e-5)) << "row by row, from the top left";
  for (const auto& point : cloud->points) EXPECT_NEAR(point.z(), 1.0F, 1e-5F);
}

TEST_P(BeforeAWall, WhatStandsBesideItIsRemoved) {
  depth_.fill([](int x, int y) { return in_square(x, y) ? 1.0 : x < 55 ? 0.7 : kWallM; });  // nearer, too
  const auto cloud = object_cloud(depth_.view(), small_camera(), kBox, {});
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->points.size(), 1600U);
}

TEST_P(BeforeAWall, HolesAreNoPoints) {
  depth_.fill([](int x, int y) { return (x + y) % 7 == 0 ? 0.0 : in_square(x, y) ? 1.0 : kWallM; });
  const auto cloud = object_cloud(depth_.view(), small_camera(), kBox, {});
  ASSERT_TRUE(cloud) << cloud.error().message;
  int valid = 0;
  for (int y = 40; y < 80; ++y)
    for (int x = 60; x < 100; ++x) valid += (x + y) % 7 == 0 ? 0 : 1;
  EXPECT_EQ(cloud->points.size(), static_cast<std::size_t>(valid)) << "lines of holes divide nothing";
}

TEST_P(BeforeAWall, ABoxThatReachesOutOfTheImageIsClipped) {
  depth_.fill([](int x, int) { return x < 30 ? 1.0 : kWallM; });
  const auto cloud = object_cloud(depth_.view(), small_camera(), {-40, 20, 40, 60}, {});
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->points.size(), 30U * 40U);
}

INSTANTIATE_TEST_SUITE_P(All, BeforeAWall, testing::Values(PixelFormat::kDepth16Mm, PixelFormat::kDepth32M),
                         [](const auto& test) { return std::string(encoding_of(test.param)); });

/// How many points of a cloud are the object's, and how many of the object's pixels are in it.
struct Quality {
  double precision{0};
  double recall{0};
};

Quality quality_of(const ObjectCloud& cloud, const View& view, const Standing& object) {
  const CameraModel camera = fit_camera();
  const Pose world_T_camera = view.camera_T_world.inverse();
  const Eigen::Vector3d from = world_T_camera.translation();
  const auto is_object = [&](int x, int y) {
    const Eigen::Vector3d ray = world_T_camera.linear() * camera.back_project(x, y, 1);
    return ray_object(object, from, ray) < (ray.z() < 0 ? -from.z() / ray.z() : 20);
  };
  int all = 0;
  for (int y = static_cast<int>(view.box.y_min); y < static_cast<int>(view.box.y_max); ++y)
    for (int x = static_cast<int>(view.box.x_min); x < static_cast<int>(view.box.x_max); ++x)
      if (is_object(x, y)) ++all;
  int right = 0;
  for (const auto& point : cloud.points) {
    const Eigen::Vector2d at = camera.project(point.cast<double>());
    if (is_object(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())))) ++right;
  }
  return {static_cast<double>(right) / static_cast<double>(cloud.points.size()),
          static_cast<double>(right) / all};
}

class OnATable : public testing::TestWithParam<FitShape> {};

TEST_P(OnATable, TheTableIsRemoved) {
  Quality worst{1, 1};
  Quality without_up{1, 1};
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Rng rng(seed);
    const Standing object{GetParam(), 0.07, 0.09, rng.uniform(-0.7, 0.7)};
    const View view = view_of(object, rng.uniform(0.4, 0.8), rng.uniform(0.5, 1.0), rng, StereoNoiseModel{});
    const auto cloud = object_cloud(view.depth.view(), fit_camera(), view.box, {}, view.up());
    ASSERT_TRUE(cloud) << "seed " << seed << ": " << cloud.error().message;
    EXPECT_GT(cloud->support_px, 0);
    const auto quality = quality_of(*cloud, view, object);
    worst = {std::min(worst.precision, quality.precision), std::min(worst.recall, quality.recall)};
    const auto simple = object_cloud(view.depth.view(), fit_camera(), view.box, {});
    ASSERT_TRUE(simple) << simple.error().message;
    const auto other = quality_of(*simple, view, object);
    without_up = {std::min(without_up.precision, other.precision), std::min(without_up.recall, other.recall)};
  }
  RecordProperty("worst_precision", std::to_string(worst.precision));
  RecordProperty("worst_recall", std::to_string(worst.recall));
  EXPECT_GT(worst.precision, 0.97);
  EXPECT_GT(worst.recall, 0.75) << "pixels as near to the table as its noise are lost";
  EXPECT_GT(without_up.recall, 0.9);
  EXPECT_LT(without_up.precision, worst.precision) << "knowing `up` must be worth something";
}

INSTANTIATE_TEST_SUITE_P(All, OnATable, testing::Values(FitShape::kCube, FitShape::kSphere, FitShape::kCone));

TEST(ObjectCloudErrors, SayWhatIsWrong) {
  const auto camera = small_camera();
  const DepthImage nothing(kWidth, kHeight);
  const auto message_of = [&](const ImageView& view, const Box2& box) {
    const auto cloud = object_cloud(view, camera, box, {});
    return cloud ? std::string("no error") : cloud.error().message;
  };
  EXPECT_EQ(message_of({}, {0, 0, 10, 10}), "object cloud: give a depth image, 16UC1 or 32FC1");
  auto color = nothing.view();
  color.format = PixelFormat::kMono16;
  EXPECT_EQ(message_of(color, {0, 0, 10, 10}), "object cloud: give a depth image, 16UC1 or 32FC1");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Box2& box : {Box2{200, 0, 210, 10}, Box2{10, 10, 10, 20}, Box2{nan, 0, 10, 10}})
    EXPECT_EQ(message_of(nothing.view(), box), "object cloud: the box has no area inside the image");
  EXPECT_EQ(message_of(nothing.view(), {0, 0, 10, 10}), "object cloud: no depth measurements in the box");
}

}  // namespace
}  // namespace extperfc::depth
