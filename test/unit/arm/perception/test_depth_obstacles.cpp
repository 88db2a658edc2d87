// Depth images of scenes whose shapes are known, and the boxes that come of them.
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/depth_obstacles.hpp"
#include "extperfc/base/rng.hpp"

#include "test/unit/arm/perception/depth_scene.hpp"

namespace extperfc::arm::test {
namespace {

const Eigen::Vector3d kEye(0.32, 0, 1.55);  // before the head
constexpr double kTable = 0.8;              // [m], its top
const Eigen::Vector3d kCube(0.9, 0.2, kTable + 0.05);

Pose camera_pose() {
  return looking(kEye, {0.95, 0, kTable});
}

DepthObstaclesParams params_for_small_images() {
  DepthObstaclesParams params;
  params.low_m = {0.4, -0.7, 0.7};
  params.high_m = {1.6, 0.7, 1.4};
  params.pixel_step = 1;
  params.min_points = 2;
  return params;
}

DepthScene table() {
  DepthScene scene;
  scene.add(Box{{1.0, 1.2, 0.04}}, make_pose({1.0, 0, kTable - 0.02}));
  return scene;
}

DepthScene table_with_cube(const Eigen::Vector3d& place = kCube) {
  DepthScene scene = table();
  scene.add(Box{{0.1, 0.1, 0.1}}, make_pose(place));
  return scene;
}

class Eyes {
 public:
  explicit Eyes(const DepthObstaclesParams& params = params_for_small_images())
      : obstacles(DepthObstacles::make(both_arms(), params).value()) {}

  DepthUpdate see(const std::vector<float>& depth, double time_s, const CollisionWorld& known = {}) {
    return obstacles.update(view_of(depth, camera), camera, camera_pose(), tucked, known, time_s).value();
  }
  DepthUpdate see(const DepthScene& scene, double time_s, const CollisionWorld& known = {}) {
    return see(scene.render(camera, camera_pose(), 5), time_s, known);
  }
  /// Remembered voxels with their middle in a box about `middle`.
  [[nodiscard]] int near(const Eigen::Vector3d& middle, double half) const {
    int count = 0;
    for (const auto& voxel : obstacles.voxels())
      if ((voxel - middle).cwiseAbs().maxCoeff() < half) ++count;
    return count;
  }

  CameraModel camera = small_camera(160);
  JointVector tucked = JointVector::Zero(14);
  DepthObstacles obstacles;
};

TEST(DepthObstacles, VoxelsLieOnTheSurfacesAndCoverThem) {
  Eyes eyes;
  const DepthScene scene = table_with_cube();
  const DepthUpdate update = eyes.see(scene, 0);
  EXPECT_GT(update.seen, 500);
  EXPECT_EQ(update.robot_points, 0);
  // Nothing but the table's top and the cube: no voxel is further from them than its own half diagonal.
  for (const Eigen::Vector3d& voxel : eyes.obstacles.voxels()) {
    const bool at_top = std::abs(voxel.z() - kTable) < 0.0174;
    const bool at_cube = ((voxel - kCube).cwiseAbs().array() < 0.05 + 0.0174).all();
    const bool at_edge = voxel.z() < kTable && (std::abs(voxel.x() - 0.5) < 0.0174);
    EXPECT_TRUE(at_top || at_cube || at_edge) << voxel.transpose();
  }
  // The cube's top is seen in full: 5 x 5 voxels, its sides not counted.
  EXPECT_GE(eyes.near(kCube + Eigen::Vector3d(0, 0, 0.05), 0.051), 25);
}

TEST(DepthObstacles, BoxesHoldEveryVoxelAndNothingElse) {
  Eyes eyes;
  eyes.see(table_with_cube(), 0);
  const auto voxels = eyes.obstacles.voxels();
  double volume = 0;
  ASSERT_TRUE(eyes.obstacles.object());
  for (const Shape& shape : eyes.obstacles.object()->shapes)
    volume += std::get<Box>(shape.geometry).size_m.prod();
  EXPECT_NEAR(volume, static_cast<double>(voxels.size()) * std::pow(0.02, 3), 1e-9);
  for (const Eigen::Vector3d& voxel : voxels) {
    int holders = 0;
    for (const Shape& shape : eyes.obstacles.object()->shapes)
      if (((voxel - shape.body_T_shape.translation()).cwiseAbs().array() <
           std::get<Box>(shape.geometry).size_m.array() / 2)
              .all())
        ++holders;
    EXPECT_EQ(holders, 1);
  }
}

TEST(DepthObstacles, FewerBoxesMeanACoarserGridAndStillHoldEveryVoxel) {
  DepthObstaclesParams params = params_for_small_images();
  params.max_boxes = 8;
  Eyes eyes(params);
  const DepthUpdate update = eyes.see(table_with_cube(), 0);
  EXPECT_LE(update.boxes, 8);
  EXPECT_GT(update.box_grid_m, 0.03);
  for (const Eigen::Vector3d& voxel : eyes.obstacles.voxels()) {
    bool held = false;
    for (const Shape& shape : eyes.obstacles.object()->shapes)
      held = held || ((voxel - shape.body_T_shape.translation()).cwiseAbs().array() <
                      std::get<Box>(shape.geometry).size_m.array() / 2)
                         .all();
    EXPECT_TRUE(held);
  }
}

TEST(DepthObstacles, MillimetresAndMetresAgree) {
  Eyes metres, millimetres;
  const auto depth = table_with_cube().render(metres.camera, camera_pose(), 5);
  const auto whole = in_millimetres(depth);
  std::vector<float> rounded;
  for (const std::uint16_t value : whole) rounded.push_back(1e-3F * static_cast<float>(value));
  metres.see(rounded, 0);
  ASSERT_TRUE(millimetres.obstacles.update(view_of(whole, millimetres.camera), millimetres.camera,
                                           camera_pose(), millimetres.tucked, {}, 0));
  EXPECT_EQ(metres.obstacles.voxels(), millimetres.obstacles.voxels());
}

TEST(DepthObstacles, TheRobotIsNotAnObstacle) {
  DepthObstaclesParams params = params_for_small_images();
  params.low_m = {-0.5, -1.3, 0.1};
  params.high_m = {1.6, 1.3, 1.9};
  Eyes eyes(params);
  eyes.tucked = reaching();
  DepthScene scene = table();
  scene.add(both_arms(), reaching());
  const auto depth = scene.render(eyes.camera, camera_pose(), 5);
  const DepthUpdate update = eyes.see(depth, 0);
  EXPECT_GT(update.robot_points, 1000);
  // What is left is the table.
  for (const Eigen::Vector3d& voxel : eyes.obstacles.voxels())
    EXPECT_LE(voxel.z(), kTable + 0.0174) << voxel.transpose();
  // Where the robot is believed to be elsewhere its arms are seen: the filter is what took them out.
  Eyes wrong(params);
  wrong.see(depth, 0);
  int above = 0;
  for (const Eigen::Vector3d& voxel : wrong.obstacles.voxels()) above += voxel.z() > kTable + 0.03 ? 1 : 0;
  EXPECT_GT(above, 100);
}

TEST(DepthObstacles, TheRobotIsFreeAmongWhatItSeesOfItself) {
  DepthObstaclesParams params = params_for_small_images();
  params.low_m = {-0.5, -1.3, 0.1};
  params.high_m = {1.6, 1.3, 1.9};
  Eyes eyes(params);
  eyes.tucked = reaching();
  DepthScene scene;
  scene.add(both_arms(), reaching());
  Rng rng(5);
  auto depth = scene.render(eyes.camera, camera_pose(), 5);
  for (float& value : depth) value *= static_cast<float>(rng.normal(1, 0.002));  // 2 to 4 mm
  eyes.see(depth, 0);
  EXPECT_TRUE(eyes.obstacles.voxels().empty());
}

/// Distance of a point to both arms at reaching().
double distance_to_robot(const Eigen::Vector3d& point) {
  std::vector<Pose> poses;
  const auto& bodies = both_arms().bodies();
  body_poses(bodies, reaching().data(), poses);
  double smallest = 1e9;
  for (const auto& own : bodies.parts)
    smallest =
        std::min(smallest, distance_bound(*own.part, (poses[own.body] * own.body_T_part).inverse() * point));
  return smallest;
}

// Points beyond the padding may lie in voxels that reach up to their diagonal nearer.
TEST(DepthObstacles, TheRobotIsFreeBesideWhatIsNear) {
  DepthObstaclesParams params = params_for_small_images();
  params.low_m = {-0.5, -1.3, 0.1};
  params.high_m = {1.6, 1.3, 1.9};
  params.min_points = 1;
  params.voxel_m = 0.04;
  Eyes eyes(params);
  eyes.tucked = reaching();
  const Pose camera_T_root = camera_pose().inverse();
  Rng rng(11);
  std::vector<float> depth(static_cast<std::size_t>(eyes.camera.width * eyes.camera.height), 0.0F);
  int near = 0;
  for (const char* hand : {"left_gripper", "right_gripper"})
    for (int i = 0; i < 20'000; ++i) {
      const Eigen::Vector3d place = both_arms().link_pose(reaching(), hand).value().translation();
      const auto random = [&] { return rng.uniform(-0.15, 0.15); };
      const Eigen::Vector3d seen = camera_T_root * (place + Eigen::Vector3d(random(), random(), random()));
      const Eigen::Vector2d pixel = eyes.camera.project(seen).array().round();
      if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < eyes.camera.width &&
            pixel.y() < eyes.camera.height))
        continue;
      const double to_robot =
          distance_to_robot(camera_pose() * eyes.camera.back_project(pixel.x(), pixel.y(), seen.z()));
      if (to_robot < params.robot_padding_m + 1e-4 || to_robot > params.robot_padding_m + 2e-3) continue;
      depth[static_cast<std::size_t>(pixel.y() * eyes.camera.width + pixel.x())] =
          static_cast<float>(seen.z());
      ++near;
    }
  EXPECT_GT(near, 100);
  eyes.see(depth, 0);
  EXPECT_GT(eyes.obstacles.voxels().size(), 20U) << "what is near stays an obstacle where it can";
  CollisionWorld world;
  ASSERT_TRUE(world.add(*eyes.obstacles.object()));
  auto checker = CollisionChecker::make(both_arms(), world).value();
  const auto nearest = checker.nearest(reaching());
  ASSERT_TRUE(nearest);
  EXPECT_TRUE(checker.is_free(reaching()))
      << nearest->first << " and " << nearest->second << ": " << nearest->distance_m << " m";
}

TEST(DepthObstacles, WhatAHandCarriesIsNotAnObstacle) {
  Eyes eyes;
  eyes.tucked = reaching();
  Shape ball;
  ball.geometry = Sphere{0.06};
  CollisionWorld known;
  ASSERT_TRUE(known.attach({"ball", "left_gripper", {ball}, Pose::Identity(), {}}));
  DepthScene scene;
  scene.add(both_arms(), reaching());
  const Pose hand = both_arms().link_pose(reaching(), "left_gripper").value();
  scene.add(Sphere{0.06}, hand);
  const auto depth = scene.render(eyes.camera, camera_pose(), 5);
  eyes.see(depth, 0, known);
  EXPECT_EQ(eyes.near(hand.translation(), 0.15), 0);
  Eyes unknowing;
  unknowing.tucked = reaching();
  unknowing.see(depth, 0);
  EXPECT_GT(unknowing.near(hand.translation(), 0.15), 0);
}

TEST(DepthObstacles, KnownObjectsAreCutOut) {
  Shape cube;
  cube.geometry = Box{{0.1, 0.1, 0.1}};
  CollisionWorld known;
  ASSERT_TRUE(known.add({"cube", {cube}, make_pose(kCube)}));
  Eyes eyes;
  const DepthUpdate update = eyes.see(table_with_cube(), 0, known);
  EXPECT_GT(update.object_points, 100);
  EXPECT_EQ(eyes.near(kCube + Eigen::Vector3d(0, 0, 0.03), 0.05), 0);
  EXPECT_GT(eyes.near({0.9, -0.3, kTable}, 0.05), 0);  // the table stays
}

// An object is seen before a detector names it; from then on it is one to hold, without waiting for an image.
TEST(DepthObstacles, AnObjectThatBecomesKnownIsForgotten) {
  Shape cube;
  cube.geometry = Box{{0.1, 0.1, 0.1}};
  CollisionWorld known;
  ASSERT_TRUE(known.add({"cube", {cube}, make_pose(kCube)}));
  Eyes eyes;
  eyes.see(table_with_cube(), 0);
  const auto all = eyes.obstacles.voxels().size();
  EXPECT_GT(eyes.near(kCube, 0.07), 20);
  EXPECT_TRUE(eyes.obstacles.forget(known));
  const auto left = eyes.obstacles.voxels();
  EXPECT_LT(left.size(), all);
  EXPECT_EQ(eyes.near(kCube, 0.06), 0);
  EXPECT_GT(eyes.near({0.9, -0.3, kTable}, 0.05), 0) << "the table stays";
  EXPECT_FALSE(eyes.obstacles.forget(known)) << "there is nothing more";
  ASSERT_TRUE(eyes.obstacles.object());
  for (const Shape& box : eyes.obstacles.object()->shapes) {
    const Eigen::Vector3d off = (box.body_T_shape.translation() - kCube).cwiseAbs();
    const Eigen::Vector3d reach = std::get<Box>(box.geometry).size_m / 2;
    EXPECT_TRUE(((off - reach).array() > 0.05 - 1e-9).any()) << "the boxes went with the voxels";
  }
  eyes.see(table_with_cube(), 0.1, known);
  EXPECT_EQ(eyes.near(kCube, 0.06), 0);
}

TEST(DepthObstacles, ForgettingWithoutImagesOrObjectsDoesNothing) {
  CollisionWorld known;
  Eyes eyes;
  EXPECT_FALSE(eyes.obstacles.forget(known));
  eyes.see(table_with_cube(), 0);
  const auto all = eyes.obstacles.voxels().size();
  EXPECT_FALSE(eyes.obstacles.forget(known));
  ASSERT_TRUE(known.add(*eyes.obstacles.object())) << "its own object is none that is known";
  EXPECT_FALSE(eyes.obstacles.forget(known));
  EXPECT_EQ(eyes.obstacles.voxels().size(), all);
}

TEST(DepthObstacles, AnObjectThatMovedIsCleared) {
  Eyes eyes;
  eyes.see(table_with_cube(), 0);
  const Eigen::Vector3d upper = kCube + Eigen::Vector3d(0, 0, 0.02), elsewhere(1.1, -0.3, kTable + 0.07);
  EXPECT_GT(eyes.near(upper, 0.055), 20);
  EXPECT_EQ(eyes.near(elsewhere, 0.05), 0);
  const DepthUpdate update = eyes.see(table_with_cube({1.1, -0.3, kTable + 0.05}), 0.1);
  EXPECT_GT(update.cleared, 20);
  // All but the lowest layer, which is within the margin of the table behind it.
  EXPECT_EQ(eyes.near(kCube + Eigen::Vector3d(0, 0, 0.04), 0.045), 0);
  EXPECT_GT(eyes.near(elsewhere, 0.055), 20);
}

// A known table behind it: nothing is left over, down to the table's padding.
TEST(DepthObstacles, AnObjectThatLeftAKnownTableIsCleared) {
  Shape top;
  top.geometry = Box{{1.0, 1.2, 0.04}};
  CollisionWorld known;
  ASSERT_TRUE(known.add({"table", {top}, make_pose({1.0, 0, kTable - 0.02})}));
  Eyes eyes;
  eyes.see(table_with_cube(), 0, known);
  EXPECT_GT(eyes.near(kCube, 0.07), 20);
  eyes.see(table(), 0.1, known);
  EXPECT_EQ(eyes.near(kCube, 0.07), 0);
}

TEST(DepthObstacles, WhatIsHiddenStaysUntilItIsTooOld) {
  DepthObstaclesParams params = params_for_small_images();
  params.max_age_s = 2;
  Eyes eyes(params);
  eyes.see(table_with_cube(), 0);
  const int before = eyes.near(kCube, 0.07);
  DepthScene board;  // right before the camera
  board.add(Box{{0.02, 3, 3}}, make_pose({0.42, 0, 1.3}));
  eyes.see(board, 1);
  EXPECT_EQ(eyes.near(kCube, 0.07), before);
  const DepthUpdate update = eyes.see(board, 2.5);
  EXPECT_EQ(eyes.near(kCube, 0.07), 0);
  EXPECT_GT(update.forgotten, 500);
}

TEST(DepthObstacles, PixelsWithoutDepthShowNothingAndClearNothing) {
  Eyes eyes;
  eyes.see(table_with_cube(), 0);
  const auto before = eyes.obstacles.voxels();
  const std::size_t pixels =
      static_cast<std::size_t>(eyes.camera.width) * static_cast<std::size_t>(eyes.camera.height);
  for (const float none :
       {0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    const DepthUpdate update = eyes.see(std::vector<float>(pixels, none), 0.1);
    EXPECT_EQ(update.points, 0);
    EXPECT_EQ(eyes.obstacles.voxels(), before);
  }
  // Far beyond: all is seen empty but for what only a corner of the image shows.
  EXPECT_LT(eyes.see(std::vector<float>(pixels, 4.9F), 0.2).voxels, 5);
}

TEST(DepthObstacles, SinglePointsAreNoise) {
  DepthObstaclesParams params = params_for_small_images();
  params.min_points = 3;
  Eyes eyes(params);
  Rng rng(3);
  std::vector<float> depth(
      static_cast<std::size_t>(eyes.camera.width) * static_cast<std::size_t>(eyes.camera.height), 0);
  for (int i = 0; i < 300; ++i)
    depth[static_cast<std::size_t>(rng.integer(0, static_cast<int>(depth.size()) - 1))] =
        static_cast<float>(rng.uniform(0.6, 1.2));
  const DepthUpdate update = eyes.see(depth, 0);
  EXPECT_GT(update.points, 100);
  // Of 300 points in some 100,000 voxels of the view a voxel gets three with a chance below 300^3 / 6 / 1e10.
  EXPECT_EQ(update.voxels, 0);
}

TEST(DepthObstacles, TheObjectServesTheCollisionChecker) {
  Eyes eyes;
  CollisionWorld world;
  const JointVector state = reaching();
  ASSERT_TRUE(CollisionChecker::make(both_arms(), world).value().is_free(state));
  DepthScene scene;
  const Pose hand = both_arms().link_pose(state, "left_gripper").value();
  scene.add(Box{{0.1, 0.1, 0.1}}, hand);  // while the robot is elsewhere
  DepthObstaclesParams params = params_for_small_images();
  params.low_m = {-0.5, -1.3, 0.1};
  params.high_m = {1.6, 1.3, 1.9};
  Eyes wide(params);
  wide.see(scene, 0);
  ASSERT_TRUE(wide.obstacles.object());
  ASSERT_TRUE(world.add(*wide.obstacles.object()));
  EXPECT_FALSE(CollisionChecker::make(both_arms(), world).value().is_free(state));
}

TEST(DepthObstacles, BadInputIsRefusedAndChangesNothing) {
  Eyes eyes;
  eyes.see(table_with_cube(), 0);
  const auto before = eyes.obstacles.voxels();
  const std::vector<float> depth(
      static_cast<std::size_t>(eyes.camera.width) * static_cast<std::size_t>(eyes.camera.height), 1);
  const auto refused = [&](const ImageView& image, const CameraModel& camera, const Pose& pose,
                           const JointVector& state, double time_s) {
    const auto update = eyes.obstacles.update(image, camera, pose, state, {}, time_s);
    return !update && update.error().code == ErrorCode::kInvalidArgument;
  };
  const ImageView image = view_of(depth, eyes.camera);
  ImageView grey = image;
  grey.format = PixelFormat::kMono8;
  Pose bad = camera_pose();
  bad.translation().x() = std::nan("");
  EXPECT_TRUE(refused({}, eyes.camera, camera_pose(), eyes.tucked, 1));
  EXPECT_TRUE(refused(grey, eyes.camera, camera_pose(), eyes.tucked, 1));
  EXPECT_TRUE(refused(image, small_camera(120), camera_pose(), eyes.tucked, 1));
  EXPECT_TRUE(refused(image, eyes.camera, bad, eyes.tucked, 1));
  EXPECT_TRUE(refused(image, eyes.camera, camera_pose(), JointVector::Zero(3), 1));
  EXPECT_TRUE(refused(image, eyes.camera, camera_pose(), eyes.tucked, std::nan("")));
  EXPECT_EQ(eyes.obstacles.voxels(), before);
}

TEST(DepthObstacles, ParametersAreChecked) {
  const auto code = [](const DepthObstaclesParams& params) {
    return DepthObstacles::make(both_arms(), params).has_value();
  };
  DepthObstaclesParams params;
  EXPECT_TRUE(code(params));
  params.voxel_m = 0.001;
  EXPECT_FALSE(code(params));
  params = {};
  params.voxel_m = 0.005;
  params.high_m = {3, 3, 3};
  EXPECT_FALSE(code(params));
  params = {};
  params.high_m = params.low_m;
  EXPECT_FALSE(code(params));
  params = {};
  params.name.clear();
  EXPECT_FALSE(code(params));
}

}  // namespace
}  // namespace extperfc::arm::test
