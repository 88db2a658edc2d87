// What the ground truth says about a world: classes, extents, markers.
#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"

#include "ros/simulate/body_extent.hpp"
#include "ros/simulate/truth_classes.hpp"
#include "ros/simulate/world_markers.hpp"

namespace extperfc::ros_simulate {
namespace {

using simulate::BodySpec;
using simulate::WorldSpec;
using visualization_msgs::Marker;

BodySpec body(const std::string& name, const std::string& label, const std::vector<Shape>& shapes) {
  BodySpec spec;
  spec.name = name;
  spec.label = label;
  spec.shapes = shapes;
  return spec;
}

Shape shape(const Geometry& geometry, const Pose& pose = Pose::Identity()) {
  return {geometry, pose, {}};
}

TEST(TruthClasses, TheModelsClassesComeFirst) {
  WorldSpec world;
  world.bodies = {body("a", "chair", {}), body("b", "cube", {}), body("c", "", {}), body("d", "chair", {})};
  world.people.push_back({});
  const TruthClasses classes({"cone", "cube"}, world);
  EXPECT_EQ(classes.names(), (std::vector<std::string>{"cone", "cube", "chair", "person"}));
  EXPECT_EQ(classes.id("cube"), 1);
  EXPECT_EQ(classes.id("chair"), 2);
  EXPECT_EQ(classes.id(""), -1);
  EXPECT_EQ(classes.id("table"), -1);
}

TEST(BodyExtent, EnclosesEveryShapeWhereItIs) {
  const auto box =
      extent_of(body("b", "", {shape(Box{{1, 2, 3}}), shape(Sphere{0.5}, make_pose({2, 0, 0}))}));
  EXPECT_TRUE(box.min().isApprox(Eigen::Vector3d(-0.5, -1, -1.5)));
  EXPECT_TRUE(box.max().isApprox(Eigen::Vector3d(2.5, 1, 1.5)));
}

TEST(BodyExtent, TurnsWithItsShape) {
  const auto lying = shape(Cylinder{0.1, 2.0}, make_pose({0, 0, 0}, {0, kPi / 2, 0}));
  const auto box = extent_of(body("b", "", {lying}));
  EXPECT_NEAR(box.sizes().x(), 2.0, 1e-9);
  EXPECT_NEAR(box.sizes().y(), 0.2, 1e-9);
  EXPECT_NEAR(box.sizes().z(), 0.2, 1e-9);
}

TEST(BodyExtent, NoShapesIsEmpty) {
  EXPECT_TRUE(extent_of(body("b", "", {})).isEmpty());
}

class WorldMarkersTest : public testing::Test {
 protected:
  WorldMarkersTest() {
    world_.bodies = {body("box", "", {shape(Box{{1, 2, 3}}, make_pose({0, 0, 1.5}))}),
                     body("cone", "cone", {shape(Cone{0.1, 0.3}), shape(Sphere{0.2})})};
    world_.people.push_back({"ann", {{0, 0}}, 0.8, false, {}});
    snapshot_.world_T_body = {Pose::Identity(), Pose::Identity()};
    snapshot_.world_T_person = {{0, 0, 0}};
  }
  WorldSpec world_;
  simulate::Snapshot snapshot_;
};

TEST_F(WorldMarkersTest, EveryShapeHasAMarkerWithANumberOfItsOwn) {
  const WorldMarkers markers(world_);
  const auto array = markers.all(snapshot_, ros::Time(5.0));
  ASSERT_EQ(array.markers.size(), 3U + 4U) << "three shapes, and a person of four";
  for (std::size_t i = 0; i < array.markers.size(); ++i) {
    const auto& marker = array.markers[i];
    EXPECT_EQ(marker.header.frame_id, "map");
    EXPECT_EQ(marker.header.stamp, ros::Time(5.0));
    EXPECT_EQ(marker.id, static_cast<int>(i));
    EXPECT_EQ(marker.action, Marker::ADD);
    EXPECT_GT(marker.color.a, 0.0F);
    const auto& q = marker.pose.orientation;
    EXPECT_NEAR(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, 1.0, 1e-9);
  }
  EXPECT_EQ(array.markers[0].type, Marker::CUBE);
  EXPECT_EQ(array.markers[0].scale.y, 2.0);
  EXPECT_EQ(array.markers[0].pose.position.z, 1.5);
  EXPECT_EQ(array.markers[0].ns, "box");
  EXPECT_EQ(array.markers[1].type, Marker::TRIANGLE_LIST);
  EXPECT_EQ(array.markers[1].points.size() % 3, 0U);
  EXPECT_EQ(array.markers[2].type, Marker::SPHERE);
  EXPECT_EQ(array.markers[2].scale.x, 0.4);
}

TEST_F(WorldMarkersTest, OnlyMovedObjectsArePublished) {
  WorldMarkers markers(world_);
  EXPECT_TRUE(markers.moved(snapshot_, ros::Time(1.0)).markers.empty());
  snapshot_.world_T_body[1].translation().x() = 0.5;
  const auto moved = markers.moved(snapshot_, ros::Time(2.0));
  ASSERT_EQ(moved.markers.size(), 2U);
  EXPECT_EQ(moved.markers[0].ns, "cone");
  EXPECT_EQ(moved.markers[0].pose.position.x, 0.5);
  EXPECT_TRUE(markers.moved(snapshot_, ros::Time(3.0)).markers.empty()) << "published already";
  snapshot_.world_T_person[0].yaw = 0.5;
  EXPECT_EQ(markers.moved(snapshot_, ros::Time(4.0)).markers.size(), 4U);
}

TEST_F(WorldMarkersTest, SlowMotionIsPublishedWhenItIsLargeEnough) {
  WorldMarkers markers(world_);
  std::size_t published = 0;
  for (int i = 0; i < 10; ++i) {
    snapshot_.world_T_body[0].translation().x() += 0.0004;
    published += markers.moved(snapshot_, ros::Time(1.0)).markers.size();
  }
  EXPECT_EQ(published, 3U);
}

}  // namespace
}  // namespace extperfc::ros_simulate
