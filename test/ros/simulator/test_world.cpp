// The base and the world around it: driving, moving objects, the ground truth, two robots of one master.
#include <cmath>

#include <geometry_msgs/Twist.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Odometry.h>
#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <vision_msgs/Detection2DArray.h>
#include <vision_msgs/Detection3DArray.h>
#include <vision_msgs/VisionInfo.h>
#include <visualization_msgs/MarkerArray.h>

#include "ros/params/detector_params.hpp"
#include "test/ros/simulator/simulator_test.hpp"
#include "test/ros/support/inbox.hpp"

namespace extperfc::ros_test {
namespace {

using std::hypot;

MoveBody::Response move(const std::string& name, double x, double y, double z = 0.0) {
  MoveBody::Request request;
  request.name = name;
  request.pose.position.x = x;
  request.pose.position.y = y;
  request.pose.position.z = z;
  request.pose.orientation.w = 1.0;
  return call<MoveBody>("sim/move_body", request);
}

class Driving : public SimulatorTest {
 protected:
  void start(const Params& params) {
    load(params);
    ASSERT_TRUE(wait_for([this] {
      return truth_.connected() && odom_.connected() && imu_.connected() && command_.getNumSubscribers() > 0;
    }));
  }
  /// Commands this velocity over and over until the truth meets the condition.
  bool drive_until(double vx, double vy, double wz,
                   const std::function<bool(const nav_msgs::Odometry&)>& condition) {
    geometry_msgs::Twist twist;
    twist.linear.x = vx;
    twist.linear.y = vy;
    twist.angular.z = wz;
    return wait_for([&] {
      command_.publish(twist);
      step(12);
      return truth_.count() > 0 && condition(*truth_.all().back());
    });
  }

  Inbox<nav_msgs::Odometry> truth_{"sim/truth/odom"};
  Inbox<nav_msgs::Odometry> odom_{"odom"};
  Inbox<sensor_msgs::Imu> imu_{"imu/data"};
  ros::Publisher command_{ros::NodeHandle().advertise<geometry_msgs::Twist>("cmd_vel", 10)};
};

TEST_F(Driving, DrivesForwardAndSidewaysAndTurns) {
  start(small_simulation());
  // The robot looks along y from (-1, 0.5).
  EXPECT_TRUE(drive_until(0.5, 0, 0, [](const auto& truth) { return truth.pose.pose.position.y > 0.8; }));
  EXPECT_NEAR(truth_.all().back()->pose.pose.position.x, -1.0, 0.05);
  EXPECT_TRUE(drive_until(0, -0.5, 0, [](const auto& truth) { return truth.pose.pose.position.x > -0.7; }));
  EXPECT_TRUE(drive_until(0, 0, 1.0, [](const auto& truth) { return truth.pose.pose.orientation.z > 0.9; }));
  EXPECT_GT(imu_.all().back()->angular_velocity.z, 0.3);
  EXPECT_NEAR(imu_.all().back()->linear_acceleration.z, 9.81, 0.2);
  EXPECT_EQ(imu_.all().back()->header.frame_id, "imu_link");
}

TEST_F(Driving, OdometryCountsFromItsStartAndGrowsUnsure) {
  start(small_simulation());
  step(12);
  ASSERT_TRUE(odom_.wait_for_count(1));
  const auto first = odom_.all().front();
  EXPECT_EQ(first->header.frame_id, "odom");
  EXPECT_EQ(first->child_frame_id, "base_footprint");
  EXPECT_NEAR(first->pose.pose.position.x, 0.0, 1e-3);
  EXPECT_TRUE(drive_until(0.5, 0, 0, [](const auto& truth) { return truth.pose.pose.position.y > 1.0; }));
  const auto truth = truth_.all().back();
  const auto last = odom_.wait_for_stamp(truth->header.stamp);
  ASSERT_TRUE(last);
  EXPECT_NEAR(last->pose.pose.position.x, truth->pose.pose.position.y - 0.5, 0.05)
      << "forwards from where it began";
  EXPECT_GT(last->pose.covariance[0], first->pose.covariance[0]);
  EXPECT_GT(last->pose.covariance[35], first->pose.covariance[35]);
  for (const int i : {0, 7, 14, 21, 28, 35}) EXPECT_GT(last->twist.covariance[i], 0.0);
}

TEST_F(Driving, StopsWhenCommandsEnd) {
  start(small_simulation());
  ASSERT_TRUE(drive_until(0.4, 0, 0, [](const auto& truth) { return truth.twist.twist.linear.x > 0.3; }));
  step(240);  // the time-out of 0.2 s, and time to brake
  EXPECT_TRUE(wait_for([&] { return std::abs(truth_.all().back()->twist.twist.linear.x) < 1e-3; }));
}

TEST_F(Driving, IgnoresCommandsThatAreNoNumbers) {
  start(small_simulation());
  geometry_msgs::Twist twist;
  twist.linear.x = std::nan("");
  command_.publish(twist);
  ASSERT_TRUE(log_.wait("cmd_vel has numbers that are not finite"));
  step(120);
  ASSERT_TRUE(truth_.wait_for_count(25));
  EXPECT_NEAR(truth_.all().back()->pose.pose.position.y, 0.5, 0.01);
}

TEST_F(Driving, TheRobotCanBePutElsewhere) {
  start(small_simulation());
  EXPECT_TRUE(move("robot", 1.0, -1.0).success);
  step(12);
  ASSERT_TRUE(truth_.wait_for_count(1) && odom_.wait_for_count(1));
  EXPECT_NEAR(truth_.all().back()->pose.pose.position.x, 1.0, 1e-6);
  EXPECT_NEAR(odom_.all().back()->pose.pose.position.x, 0.0, 0.01) << "odometry does not know of it";
}

class World : public SimulatorTest {};

/// Points of a sweep within 0.6 m of a place of the map and well above the floor; the robot stands at
/// (-1, 0.5) and looks along y.
std::size_t points_near(const sensor_msgs::PointCloud2& cloud, double map_x, double map_y) {
  std::size_t count = 0;
  sensor_msgs::PointCloud2ConstIterator<float> xyz(cloud, "x");
  for (; xyz != xyz.end(); ++xyz) {
    const double x = -1.0 - xyz[1];
    const double y = 0.5 + xyz[0];
    if (hypot(x - map_x, y - map_y) < 0.6 && std::abs(xyz[2]) < 0.2) ++count;
  }
  return count;
}

TEST_F(World, AMovedBodyIsSeenWhereItIs) {
  const Inbox<sensor_msgs::PointCloud2> cloud("velodyne_points");
  load(with(small_simulation(), {{"lidar/columns", 360}}));
  ASSERT_TRUE(wait_for([&] { return cloud.connected(); }));
  step(48);
  ASSERT_TRUE(cloud.wait_for_count(1));
  EXPECT_EQ(points_near(*cloud.all().back(), 0.8, 0.5), 0U) << "free so far";
  EXPECT_TRUE(move("carton", 0.8, 0.5, 0.0).success);
  step(24);
  ASSERT_TRUE(cloud.wait_for_count(2));
  EXPECT_GT(points_near(*cloud.all().back(), 0.8, 0.5), 20U);
}

TEST_F(World, WhatCannotBeMovedIsRefusedByName) {
  load(small_simulation());
  EXPECT_NE(move("walls", 0, 0).message.find("walls"), std::string::npos);
  EXPECT_FALSE(move("walls", 0, 0).success);
  EXPECT_NE(move("unicorn", 0, 0).message.find("unicorn"), std::string::npos);
  MoveBody::Request no_rotation;
  no_rotation.name = "carton";
  const auto response = call<MoveBody>("sim/move_body", no_rotation);
  EXPECT_FALSE(response.success);
  EXPECT_NE(response.message.find("w = 1"), std::string::npos) << response.message;
}

TEST_F(World, TheTruthNamesTheCubeAndItsPlace) {
  const Inbox<vision_msgs::Detection3DArray> objects("sim/truth/objects");
  const Inbox<vision_msgs::VisionInfo> info("sim/truth/vision_info");
  load(small_simulation());
  ASSERT_TRUE(wait_for([&] { return objects.connected() && info.count() > 0; }));
  const auto names = ros_params::load_class_names(info.all().front()->database_location);
  ASSERT_GE(names.size(), 3U);
  EXPECT_EQ(names[1], "cube") << "the order of the detector's model";
  step(24);
  ASSERT_TRUE(objects.wait_for_count(1));
  const auto message = objects.all().back();
  EXPECT_EQ(message->header.frame_id, "map");
  ASSERT_EQ(message->detections.size(), 1U);
  const auto& cube = message->detections.front();
  EXPECT_EQ(cube.results.at(0).id, 1);
  EXPECT_NEAR(cube.bbox.center.position.x, 1.5, 0.01);
  EXPECT_NEAR(cube.bbox.center.position.y, 1.5, 0.01);
  EXPECT_NEAR(cube.bbox.center.position.z, 0.025, 0.005);
  EXPECT_NEAR(cube.bbox.size.x, 0.05, 1e-6);
}

/// A body's origin is its centre of mass, which a cone has at a quarter of its height.
TEST_F(World, TheTruthOfAnObjectIsItsCentreWhereverItIsRead) {
  const Inbox<vision_msgs::Detection3DArray> objects("sim/truth/objects");
  load(with(small_simulation(), {{"world", "grasp"}}));
  ASSERT_TRUE(wait_for([&] { return objects.connected(); }));
  step(24);
  ASSERT_TRUE(objects.wait_for_count(1));
  const auto message = objects.all().back();
  ASSERT_EQ(message->detections.size(), 3U) << "cube, sphere and cone";
  constexpr double kTableM = 0.7;
  for (const auto& object : message->detections) {
    const auto& result = object.results.at(0);
    EXPECT_NEAR(object.bbox.center.position.z, kTableM + 0.5 * object.bbox.size.z, 0.005) << result.id;
    EXPECT_EQ(result.pose.pose, object.bbox.center) << result.id;
    EXPECT_GT(result.pose.covariance[0], 0.0) << "0 would say that nothing is known";
    EXPECT_LT(result.pose.covariance[0], 1e-6);
  }
}

TEST_F(World, LabelsAndBoxesShowWhatTheCameraSees) {
  const Inbox<sensor_msgs::Image> labels("sim/truth/labels");
  const Inbox<vision_msgs::Detection2DArray> boxes("sim/truth/detections");
  load(with(small_simulation(), {{"camera/width", 320}, {"camera/height", 240}}));
  ASSERT_TRUE(wait_for([&] { return labels.connected() && boxes.connected(); }));
  EXPECT_TRUE(move("cube", -1.0, 2.0, 0.025).success);  // on the floor, where the camera looks
  step(16);
  ASSERT_TRUE(labels.wait_for_count(1) && boxes.wait_for_count(1));
  const auto& image = *labels.all().front();
  EXPECT_EQ(image.encoding, "16UC1");
  ASSERT_EQ(boxes.all().front()->detections.size(), 1U);
  const auto& box = boxes.all().front()->detections.front();
  EXPECT_EQ(box.results.at(0).id, 1);
  const auto column = static_cast<std::size_t>(box.bbox.center.x);
  const auto row = static_cast<std::size_t>(box.bbox.center.y);
  std::uint16_t number = 0;
  std::memcpy(&number, &image.data[row * image.step + 2 * column], 2);
  std::vector<std::string> instances;
  ASSERT_TRUE(ros::param::get("/simulator/instances", instances));
  ASSERT_LT(number, instances.size());
  EXPECT_EQ(instances[number], "cube");
}

TEST_F(World, TheTrueMapIsThereForLateListeners) {
  load(small_simulation());
  const Inbox<nav_msgs::OccupancyGrid> map("sim/truth/map");
  ASSERT_TRUE(map.wait_for_count(1));
  const auto& grid = *map.all().front();
  EXPECT_EQ(grid.header.frame_id, "map");
  EXPECT_NEAR(grid.info.resolution, 0.05, 1e-6);
  const auto cell = [&](double x, double y) {
    const auto column = static_cast<std::size_t>((x - grid.info.origin.position.x) / grid.info.resolution);
    const auto row = static_cast<std::size_t>((y - grid.info.origin.position.y) / grid.info.resolution);
    return static_cast<int>(grid.data.at(row * grid.info.width + column));
  };
  EXPECT_EQ(cell(-1.0, 0.5), 0) << "where the robot is";
  EXPECT_EQ(cell(2.94, 0.0), 100) << "a wall";
  EXPECT_EQ(cell(2.0, -2.0), 100) << "the carton";
}

TEST_F(World, MarkersComeToEachNewListenerAndAfterMoves) {
  load(small_simulation());
  const Inbox<visualization_msgs::MarkerArray> markers("sim/world_markers");
  ASSERT_TRUE(markers.wait_for_count(1)) << "even while time stands still";
  const std::size_t all = markers.all().front()->markers.size();
  EXPECT_GE(all, 6U) << "floor, four walls or more, carton, cube";
  EXPECT_TRUE(move("carton", 0.0, -2.0).success);
  step(240);
  EXPECT_TRUE(wait_for([&] {
    const auto latest = markers.all().back();
    return latest->markers.size() < all && latest->markers.front().ns == "carton" &&
           std::abs(latest->markers.front().pose.position.y + 2.0) < 0.31;
  })) << "only what moved";
}

TEST_F(World, TwoRobotsLiveInTwoNamespaces) {
  const Inbox<nav_msgs::Odometry> a("/a/sim/truth/odom");
  const Inbox<nav_msgs::Odometry> b("/b/sim/truth/odom");
  const Inbox<sensor_msgs::JointState> a_joints("/a/robot/joint_states");
  const Inbox<rosgraph_msgs::Clock> clock("/clock");
  load(small_simulation(), "/a/simulator");
  load(with(small_simulation(), {{"time/publish_clock", false}}), "/b/simulator");
  ASSERT_TRUE(wait_for([&] { return a.connected() && b.connected() && a_joints.connected(); }));
  step(48, "/b");
  EXPECT_TRUE(b.wait_for_count(10));
  EXPECT_EQ(a.count(), 0U) << "the other one's time stands still";
  ASSERT_TRUE(clock.wait_for_count(1));
  EXPECT_EQ(clock.all().back()->clock, ros::Time(1.0)) << "the clock is a's";
  step(48, "/a");
  EXPECT_TRUE(a.wait_for_count(10));
  EXPECT_TRUE(a_joints.wait_for_count(20));
}

}  // namespace
}  // namespace extperfc::ros_test
