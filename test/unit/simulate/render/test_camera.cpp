// Images of small worlds against geometry.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "test/unit/simulate/render/small_world.hpp"

namespace extperfc::simulate {
namespace {

constexpr int kFirstBody = 2;  // instance number of the first body

SmallWorld two_balls() {
  SmallWorld world;
  world.add("left", Sphere{0.3}, at(2.5, 0.6, 0)).add("right", Sphere{0.2}, at(3.0, -0.5, 0.3));
  return world;
}

CameraImages camera_images(SensorRig& rig, const CameraParams& params,
                           const Pose& pose = forward_camera({0, 0, 0})) {
  CameraImages images;
  rig.camera(params, pose, images);
  return images;
}

double mean_of(const std::vector<std::uint8_t>& values) {
  double sum = 0;
  for (const auto value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

TEST(Camera, DepthOfASphereIsAlongTheOpticalAxis) {
  SmallWorld world;
  world.add("ball", Sphere{0.3}, at(2, 0, 0));
  const auto rig = world.rig();
  const auto images = camera_images(*rig, exact_camera(161, 121));
  const std::size_t centre = 60 * 161 + 80;
  EXPECT_NEAR(images.true_depth_m[centre], 1.7, 1e-4);
  EXPECT_EQ(images.depth_mm[centre], 1700);
  EXPECT_EQ(images.instance[centre], kFirstBody);
  EXPECT_EQ(images.true_depth_m[0], 0.0F);
  EXPECT_EQ(images.depth_mm[0], 0);
  EXPECT_EQ(images.instance[0], 0);
}

TEST(Camera, DepthOfAWallIsTheSameInEveryPixel) {
  // Depth is along the axis, not along the ray.
  SmallWorld world;
  world.add("wall", Box{{0.1, 20, 20}}, at(4.05, 0, 0));
  const auto rig = world.rig();
  const auto images = camera_images(*rig, exact_camera());
  for (const float depth : images.true_depth_m) ASSERT_NEAR(depth, 4.0F, 1e-4F);
}

TEST(Camera, LensDistortionBendsRaysAsTheModelSays) {
  SmallWorld world;
  world.add("ball", Sphere{0.05}, at(2, 0.5, 0.3));
  const auto rig = world.rig();
  auto params = exact_camera(320, 240, 300);
  params.model.distortion = {0.15, -0.1, 0.002, -0.001, 0.0};
  const auto boxes = visible_boxes(camera_images(*rig, params), rig->instances(), 1);
  ASSERT_EQ(boxes.size(), 1U);
  const Eigen::Vector2d expected = params.model.project({-0.5, -0.3, 2});
  EXPECT_NEAR(0.5 * (boxes[0].x_min + boxes[0].x_max), expected.x(), 1.0);
  EXPECT_NEAR(0.5 * (boxes[0].y_min + boxes[0].y_max), expected.y(), 1.0);
}

/// Image columns between which a sphere lies: tangents at the angle of its centre +- asin(r / d).
void expect_box(const VisibleBox& box, const CameraModel& model, const Eigen::Vector3d& centre,
                double radius) {
  const auto ends = [&](double side, double c, double f) {
    const double middle = std::atan2(side, centre.x());
    const double half = std::asin(radius / std::hypot(side, centre.x()));
    return std::make_pair(c + f * std::tan(middle - half), c + f * std::tan(middle + half));
  };
  const auto [left, right] = ends(-centre.y(), model.cx, model.fx);
  const auto [top, bottom] = ends(-centre.z(), model.cy, model.fy);
  EXPECT_NEAR(box.x_min, std::ceil(left), 1.0);
  EXPECT_NEAR(box.x_max, std::floor(right), 1.0);
  EXPECT_NEAR(box.y_min, std::ceil(top), 1.0);
  EXPECT_NEAR(box.y_max, std::floor(bottom), 1.0);
}

TEST(Camera, VisibleBoxesOfSpheresAreTheirOutlines) {
  auto world = two_balls();
  const auto rig = world.rig();
  const auto params = exact_camera(640, 480, 600);
  const auto boxes = visible_boxes(camera_images(*rig, params), rig->instances(), 10);
  ASSERT_EQ(boxes.size(), 2U);
  EXPECT_EQ(rig->instances()[boxes[0].instance].name, "left");
  EXPECT_EQ(rig->instances()[boxes[1].instance].body, 1);
  expect_box(boxes[0], params.model, {2.5, 0.6, 0}, 0.3);
  expect_box(boxes[1], params.model, {3.0, -0.5, 0.3}, 0.2);
}

TEST(Camera, BoxesNeedALabelAndEnoughPixels) {
  auto world = two_balls();
  world.spec.bodies[1].label.clear();
  const auto rig = world.rig();
  const auto images = camera_images(*rig, exact_camera());
  const auto boxes = visible_boxes(images, rig->instances(), 1);
  ASSERT_EQ(boxes.size(), 1U);
  const auto pixels = std::count(images.instance.begin(), images.instance.end(), kFirstBody);
  EXPECT_EQ(boxes[0].pixels, pixels);
  EXPECT_TRUE(visible_boxes(images, rig->instances(), static_cast<int>(pixels) + 1).empty());
}

TEST(Camera, MovingABodyMovesItsImage) {
  auto world = two_balls();
  const auto rig = world.rig();
  const auto before = visible_boxes(camera_images(*rig, exact_camera()), rig->instances(), 1);
  auto snapshot = world.snapshot();
  snapshot.world_T_body[0].translation().y() -= 0.25;
  rig->pose(snapshot);
  const auto after = visible_boxes(camera_images(*rig, exact_camera()), rig->instances(), 1);
  ASSERT_EQ(before.size(), 2U);
  ASSERT_EQ(after.size(), 2U);
  EXPECT_NEAR(after[0].x_min - before[0].x_min, 150 * 0.25 / 2.5, 1.5);
  EXPECT_EQ(after[1].x_min, before[1].x_min);
}

TEST(Camera, PeopleStandWhereTheSnapshotSays) {
  SmallWorld world;
  world.spec.people.push_back({"anna", {{3, 0}}, 1, false, {0.5F, 0.1F, 0.1F}});
  const auto rig = world.rig();
  auto snapshot = world.snapshot();
  rig->pose(snapshot);
  const auto pose = forward_camera({0, 0, 0.9});
  const auto there = visible_boxes(camera_images(*rig, exact_camera(), pose), rig->instances(), 1);
  ASSERT_EQ(there.size(), 1U);
  EXPECT_EQ(rig->instances()[there[0].instance].label, "person");
  EXPECT_NEAR(there[0].y_max - there[0].y_min, 150 * 1.77 / 3, 6);
  snapshot.world_T_person[0] = {3, 5, 1};
  rig->pose(snapshot);
  EXPECT_TRUE(visible_boxes(camera_images(*rig, exact_camera(), pose), rig->instances(), 1).empty());
}

TEST(Camera, SameSeedSameTimeSameImageWhateverWasDrawnBefore) {
  auto world = two_balls();
  CameraParams params;
  params.model = exact_camera().model;
  const auto first = world.rig(3);
  const auto second = world.rig(3);
  first->pose(world.snapshot(1.5));
  second->pose(world.snapshot(7.0));
  (void)camera_images(*second, params);
  std::vector<LidarPoint> points;
  second->lidar({}, at(0, 0, 0), at(0, 0, 0), points);
  second->pose(world.snapshot(1.5));
  const auto a = camera_images(*first, params);
  const auto b = camera_images(*second, params);
  EXPECT_EQ(a.rgb, b.rgb);
  EXPECT_EQ(a.depth_mm, b.depth_mm);
  EXPECT_EQ(a.true_depth_m, b.true_depth_m);
}

TEST(Camera, NoiseDiffersBySeedTimeAndSensor) {
  auto world = two_balls();
  world.add("wall", Box{{0.1, 20, 20}}, at(5, 0, 0));
  CameraParams params;
  params.model = exact_camera().model;
  const auto rig = world.rig(3);
  rig->pose(world.snapshot(1.0));
  const auto base = camera_images(*rig, params);
  params.sensor = 1;
  const auto sensor = camera_images(*rig, params);
  params.sensor = 0;
  rig->pose(world.snapshot(1.1));
  const auto time = camera_images(*rig, params);
  const auto other = world.rig(4);
  other->pose(world.snapshot(1.0));
  const auto seed = camera_images(*other, params);
  for (const auto* changed : {&sensor, &time, &seed}) {
    EXPECT_NE(base.rgb, changed->rgb);
    EXPECT_NE(base.depth_mm, changed->depth_mm);
    EXPECT_EQ(base.true_depth_m, changed->true_depth_m);
  }
}

TEST(Camera, ColourNoiseHasItsSigma) {
  const auto rig = SmallWorld().rig();
  auto params = exact_camera(320, 240);
  params.image_noise = 0.02;
  const auto images = camera_images(*rig, params);
  const double n = 320 * 240;
  double sum = 0;
  double sum2 = 0;
  for (std::size_t i = 0; i < images.rgb.size(); i += 3) {
    sum += images.rgb[i];
    sum2 += images.rgb[i] * images.rgb[i];
  }
  const double variance = sum2 / n - sum / n * (sum / n);
  const double expected = std::pow(0.02 * 255, 2) + 1.0 / 12.0;  // and rounding to a byte
  // The variance of n values has a relative standard deviation of sqrt(2 / n) = 0.5 %; five of them.
  EXPECT_NEAR(variance, expected, 0.026 * expected);
}

TEST(Camera, NothingIsSkyColoured) {
  SmallWorld world;
  world.spec.light.sky = {0.30F, 0.60F, 0.90F};
  const auto rig = world.rig();
  const auto images = camera_images(*rig, exact_camera());
  EXPECT_NEAR(images.rgb[0], 0.30 * 255, 1.0);
  EXPECT_NEAR(images.rgb[1], 0.60 * 255, 1.0);
  EXPECT_NEAR(images.rgb[2], 0.90 * 255, 1.0);
}

/// A floor that a camera looks down at, a light above it, and a plate between them.
SmallWorld shaded_floor() {
  SmallWorld world;
  world.add("floor", Box{{10, 10, 0.1}}, at(0, 0, -0.05));
  world.add("plate", Box{{0.5, 0.5, 0.02}}, at(0, 1.0, 1.0));
  world.spec.light.position_m = {0, 2.0, 2.0};  // the plate's shadow falls around the origin
  return world;
}

Pose downward_camera(double height) {
  return make_pose({0, 0, height}, {M_PI, 0, 0});
}

TEST(Camera, ShadowsDarken) {
  auto world = shaded_floor();
  for (const bool soft : {false, true}) {
    const auto rig = world.rig();
    auto params = exact_camera(64, 48, 400);
    params.soft_light = soft;
    params.shadows = false;
    const double lit = mean_of(camera_images(*rig, params, downward_camera(0.9)).rgb);
    params.shadows = true;
    const double dark = mean_of(camera_images(*rig, params, downward_camera(0.9)).rgb);
    EXPECT_LT(dark, 0.92 * lit) << "soft " << soft;
  }
}

/// Largest step between neighbours of a row.
int sharpest_edge(const CameraImages& images) {
  int sharpest = 0;
  for (std::size_t i = 3; i < images.rgb.size(); ++i)
    if (i / 3 % static_cast<std::size_t>(images.width) != 0)
      sharpest = std::max(sharpest, std::abs(images.rgb[i] - images.rgb[i - 3]));
  return sharpest;
}

TEST(Camera, SoftShadowsFadeOverSeveralPixels) {
  auto world = shaded_floor();
  const auto rig = world.rig();
  auto params = exact_camera(320, 240, 300);
  params.soft_light = false;
  const int hard = sharpest_edge(camera_images(*rig, params, downward_camera(1.8)));
  params.soft_light = true;
  const int soft = sharpest_edge(camera_images(*rig, params, downward_camera(1.8)));
  EXPECT_GT(hard, 30);
  EXPECT_LT(soft, hard / 3);
}

TEST(Camera, SupersamplingChangesColoursOnly) {
  auto world = two_balls();
  const auto rig = world.rig();
  auto params = exact_camera();
  const auto plain = camera_images(*rig, params);
  params.supersampling = 2;
  const auto fine = camera_images(*rig, params);
  EXPECT_EQ(plain.true_depth_m, fine.true_depth_m);
  EXPECT_EQ(plain.instance, fine.instance);
  EXPECT_EQ(plain.depth_mm, fine.depth_mm);
  EXPECT_NE(plain.rgb, fine.rgb);
  EXPECT_NEAR(mean_of(plain.rgb), mean_of(fine.rgb), 1.0);
}

TEST(Camera, AnySizeWorksAndAnInvalidModelGivesAnEmptyImage) {
  auto world = two_balls();
  const auto rig = world.rig();
  for (const auto& [width, height] :
       {std::pair(1, 1), std::pair(5, 3), std::pair(17, 2), std::pair(64, 33)}) {
    auto params = exact_camera(width, height, 20);
    params.supersampling = width % 2 + 1;
    const auto images = camera_images(*rig, params);
    EXPECT_EQ(images.rgb.size(), 3U * static_cast<std::size_t>(width * height));
  }
  auto params = exact_camera();
  params.model.fx = 0;
  EXPECT_EQ(camera_images(*rig, params).width, 0);
  EXPECT_TRUE(camera_images(*rig, params).rgb.empty());
}

SmallWorld still_life() {
  SmallWorld world;
  const Material wood{{0.75F, 0.55F, 0.35F}, Texture::kWood, 0.8F, 0.1F};
  const Material plaster{{0.85F, 0.85F, 0.80F}, Texture::kPlaster, 1.5F, 0};
  world.add("table", Box{{1.2, 1.6, 0.04}}, at(1.2, 0, 0.70), wood, Mobility::kFixed);
  world.add("wall", Box{{0.1, 6, 3}}, at(3, 0, 1.5), plaster, Mobility::kFixed);
  world.add("cone", Cone{0.06, 0.15}, at(1.0, 0.25, 0.795), {{0.9F, 0.1F, 0.1F}, Texture::kNone, 1, 0.2F});
  world.add("cube", Box{{0.12, 0.12, 0.12}}, make_pose({1.2, -0.1, 0.78}, {0, 0, 0.5}), {{0.1F, 0.3F, 0.8F}});
  world.add("sphere", Sphere{0.07}, at(0.95, -0.35, 0.79), {{0.95F, 0.8F, 0.1F}, Texture::kNone, 1, 0.4F});
  world.spec.people.push_back({"anna", {{2.3, 0.9}}, 1, false, {0.2F, 0.5F, 0.3F}});
  world.spec.light.position_m = {0.6, 0.8, 2.5};
  return world;
}

/// Means over 5 x 5 pixels.
std::vector<int> block_means(const CameraImages& images) {
  std::vector<int> means;
  for (int y = 0; y < images.height; y += 5) {
    for (int x = 0; x < images.width; x += 5) {
      for (int channel = 0; channel < 3; ++channel) {
        int sum = 0;
        for (int i = 0; i < 25; ++i)
          sum += images.rgb[3 * ((y + i / 5) * images.width + x + i % 5) + channel];
        means.push_back((sum + 12) / 25);
      }
    }
  }
  return means;
}

TEST(Camera, StillLifeLooksAsItDid) {
  const auto world = still_life();
  const auto rig = world.rig();
  Pose pose = forward_camera({0, 0, 1.35});
  pose.linear() = pose.linear() * Eigen::AngleAxisd(-0.45, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const auto means = block_means(camera_images(*rig, exact_camera(160, 120, 150), pose));
  const std::string file = std::string(EXTPERFC_TEST_DATA) + "/simulate/still_life.txt";
  if (std::getenv("EXTPERFC_WRITE_GOLDEN") != nullptr) {  // after a wanted change; look at the image first
    std::ofstream out(file);
    for (std::size_t i = 0; i < means.size(); ++i) out << means[i] << ((i + 1) % 96 == 0 ? '\n' : ' ');
  }
  std::ifstream in(file);
  const std::vector<int> golden{std::istream_iterator<int>(in), {}};
  ASSERT_EQ(golden.size(), means.size()) << file;
  double difference = 0;
  for (std::size_t i = 0; i < means.size(); ++i) {
    difference += std::abs(means[i] - golden[i]);
    EXPECT_LE(std::abs(means[i] - golden[i]), 16) << "block " << i / 3 % 32 << ", " << i / 96;
  }
  EXPECT_LT(difference / static_cast<double>(means.size()), 1.0);
}

}  // namespace
}  // namespace extperfc::simulate
