// Every fault, by service and by parameter.
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <set>
#include <sstream>

#include <baxter_core_msgs/HeadPanCommand.h>
#include <geometry_msgs/Twist.h>
#include <nav_msgs/Odometry.h>
#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include "test/ros/simulator/simulator_test.hpp"
#include "test/ros/support/child_process.hpp"
#include "test/ros/support/inbox.hpp"

namespace extperfc::ros_test {
namespace {

class Faults : public SimulatorTest {};

struct Camera {
  Inbox<sensor_msgs::Image> color{"camera/color/image_raw"};
  Inbox<sensor_msgs::Image> depth{"camera/aligned_depth_to_color/image_raw"};
  [[nodiscard]] bool connected() const {
    return wait_for([this] { return color.connected() && depth.connected(); });
  }
};

TEST_F(Faults, CameraFreezesWithNewStamps) {
  Camera camera;
  load(small_simulation());
  ASSERT_TRUE(camera.connected());
  EXPECT_TRUE(set_fault("camera_freeze", "", 1, 0.5).success);
  step(240);
  ASSERT_TRUE(camera.color.wait_for_count(15));
  const auto images = camera.color.all();
  std::set<std::vector<std::uint8_t>> frozen;
  std::set<std::vector<std::uint8_t>> live;
  for (const auto& image : images) (image->header.stamp < ros::Time(1.5) ? frozen : live).insert(image->data);
  EXPECT_EQ(frozen.size(), 1U) << "the same image for half a second";
  EXPECT_GE(live.size(), 7U) << "noise makes every live image another one";
  for (std::size_t i = 1; i < images.size(); ++i)
    EXPECT_GT(images[i]->header.stamp, images[i - 1]->header.stamp);
}

TEST_F(Faults, CameraDropsFrames) {
  Camera camera;
  load(small_simulation());
  ASSERT_TRUE(camera.connected());
  EXPECT_TRUE(set_fault("camera_drop", "", 1.0).success);
  step(240);
  EXPECT_TRUE(never([&] { return camera.color.count() > 0; }, 0.2));
  EXPECT_TRUE(set_fault("camera_drop", "", 0.5).success);
  step(960);
  EXPECT_TRUE(wait_for([&] { return camera.color.count() > 10; }));
  EXPECT_LT(camera.color.count(), 50U) << "of 60";
}

std::size_t without_depth(const sensor_msgs::Image& depth) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < depth.data.size(); i += 2)
    if (depth.data[i] == 0 && depth.data[i + 1] == 0) ++count;
  return count;
}

TEST_F(Faults, CameraSendsPixelsWithoutDepth) {
  Camera camera;
  load(small_simulation());
  ASSERT_TRUE(camera.connected());
  step(16);
  ASSERT_TRUE(camera.depth.wait_for_count(1));
  const auto usual = without_depth(*camera.depth.all().back());
  EXPECT_TRUE(set_fault("camera_nan", "", 0.8).success);
  step(16);
  ASSERT_TRUE(camera.depth.wait_for_count(2));
  const std::size_t pixels = 64 * 48;
  EXPECT_GT(without_depth(*camera.depth.all().back()), usual + (pixels - usual) * 7 / 10);
}

TEST_F(Faults, LidarLosesRingsAndSweeps) {
  const Inbox<sensor_msgs::PointCloud2> cloud("velodyne_points");
  load(small_simulation());
  ASSERT_TRUE(wait_for([&] { return cloud.connected(); }));
  EXPECT_TRUE(set_fault("lidar_rings", "3,7").success);
  step(48);
  ASSERT_TRUE(cloud.wait_for_count(1));
  std::set<int> rings;
  for (sensor_msgs::PointCloud2ConstIterator<std::uint16_t> ring(*cloud.all().back(), "ring");
       ring != ring.end(); ++ring)
    rings.insert(*ring);
  EXPECT_EQ(rings.count(3) + rings.count(7), 0U);
  EXPECT_EQ(rings.size(), 14U);
  EXPECT_TRUE(set_fault("lidar_drop", "", 1.0).success);
  step(240);
  EXPECT_TRUE(never([&] { return cloud.count() > 1; }, 0.2));
  EXPECT_TRUE(set_fault("none").success);
  step(24);
  EXPECT_TRUE(cloud.wait_for_count(2));
}

TEST_F(Faults, AJointIsStuck) {
  const Inbox<sensor_msgs::JointState> joints("robot/joint_states");
  auto pan = ros::NodeHandle().advertise<baxter_core_msgs::HeadPanCommand>("robot/head/command_head_pan", 2);
  load(running_simulation());
  const auto head = [&] {
    if (joints.count() == 0) return 0.0;
    const auto state = joints.all().back();
    for (std::size_t i = 0; i < state->name.size(); ++i)
      if (state->name[i] == "head_pan") return state->position[i];
    return 0.0;
  };
  ASSERT_TRUE(wait_for([&] { return joints.connected() && pan.getNumSubscribers() > 0; }));
  baxter_core_msgs::HeadPanCommand command;
  command.target = 0.5F;
  command.speed_ratio = 1.0F;
  command.enable_pan_request = baxter_core_msgs::HeadPanCommand::REQUEST_PAN_ENABLE;
  EXPECT_TRUE(set_fault("joint_stuck", "head_pan").success);
  pan.publish(command);
  EXPECT_TRUE(never([&] { return std::abs(head()) > 0.01; }, 0.3));
  EXPECT_TRUE(set_fault("joint_stuck", "head_pan", 1, -1).success) << "ends it";
  pan.publish(command);
  EXPECT_TRUE(wait_for([&] { return std::abs(head() - 0.5) < 0.02; })) << head();
}

TEST_F(Faults, AWheelSlips) {
  const Inbox<nav_msgs::Odometry> truth("sim/truth/odom");
  const Inbox<nav_msgs::Odometry> odom("odom");
  auto command = ros::NodeHandle().advertise<geometry_msgs::Twist>("cmd_vel", 10);
  load(small_simulation());
  ASSERT_TRUE(wait_for([&] { return truth.connected() && command.getNumSubscribers() > 0; }));
  EXPECT_TRUE(set_fault("wheel_slip", "all", 0.5).success);
  geometry_msgs::Twist twist;
  twist.linear.x = 0.4;
  ASSERT_TRUE(wait_for([&] {
    command.publish(twist);
    step(12);
    return odom.count() > 0 && odom.all().back()->pose.pose.position.x > 0.5;
  }));
  const auto believed = odom.all().back();
  const auto driven = truth.wait_for_stamp(believed->header.stamp);
  ASSERT_TRUE(driven);
  EXPECT_LT(driven->pose.pose.position.y - 0.5, 0.8 * believed->pose.pose.position.x)
      << "the wheels believe more";
}

TEST_F(Faults, TheClockJumps) {
  const Inbox<rosgraph_msgs::Clock> clock("/clock");
  load(small_simulation());
  const auto before = step(24);
  EXPECT_TRUE(set_fault("clock_jump", "", 100.0).success);
  EXPECT_NEAR((step(24) - before).toSec(), 100.1, 1e-6);
  EXPECT_TRUE(set_fault("clock_jump", "", -50.0).success);
  EXPECT_NEAR((step(24) - before).toSec(), 50.2, 1e-6);
  EXPECT_TRUE(set_fault("clock_jump", "", -1000.0).success);
  EXPECT_NEAR(step(24).toSec(), 1.1, 1e-6) << "never before the start";
}

TEST_F(Faults, ActiveFaultsAreReported) {
  load(small_simulation());
  set_fault("camera_drop", "", 0.25);
  const auto response = set_fault("lidar_rings", "1", 1, 2.0);
  ASSERT_EQ(response.active.size(), 2U);
  EXPECT_EQ(response.active[0], "camera_drop 0.25");
  EXPECT_EQ(response.active[1], "lidar_rings 1 for 2 s");
  EXPECT_TRUE(set_fault("none").active.empty());
}

TEST_F(Faults, NonsenseIsRefusedWithARemedy) {
  load(small_simulation());
  EXPECT_NE(set_fault("camera_explodes").message.find("camera_freeze"), std::string::npos);
  EXPECT_NE(set_fault("camera_drop", "", 3.0).message.find("0 to 1"), std::string::npos);
  EXPECT_NE(set_fault("joint_stuck", "knee").message.find("knee"), std::string::npos);
  EXPECT_NE(set_fault("lidar_rings", "16").message.find("16"), std::string::npos);
  EXPECT_TRUE(set_fault("none").active.empty());
}

TEST_F(Faults, ParametersSetThemFromTheStartAndAfterAReset) {
  const Inbox<sensor_msgs::Image> color("camera/color/image_raw");
  XmlRpc::XmlRpcValue faults;
  faults[0] = fault_entry("camera_drop", "", 1.0);
  faults[1] = fault_entry("clock_jump", "", 10.0);
  load(with(small_simulation(), {{"faults", faults}}));
  ASSERT_TRUE(wait_for([&] { return color.connected(); }));
  EXPECT_EQ(step(24), ros::Time(11.1));
  reset();
  EXPECT_EQ(step(24), ros::Time(11.1));
  EXPECT_TRUE(never([&] { return color.count() > 0; }, 0.2));
}

/// Where the distribution keeps the program `nodelet`.
std::string nodelet_program() {
  const char* prefixes = std::getenv("CMAKE_PREFIX_PATH");
  std::istringstream parts(std::string(prefixes ? prefixes : "") + ":/usr");
  for (std::string prefix; std::getline(parts, prefix, ':');)
    if (std::filesystem::exists(prefix + "/lib/nodelet/nodelet")) return prefix + "/lib/nodelet/nodelet";
  return "nodelet";
}

TEST_F(Faults, TheProcessDies) {
  for (const auto& [key, value] : small_simulation()) ros::param::set("/mortal/" + key, value);
  ChildProcess mortal({nodelet_program(), "standalone", "extperfc/simulator", "__name:=mortal"});
  ASSERT_TRUE(wait_for([] { return ros::service::exists("sim/set_fault", false); }));
  EXPECT_TRUE(set_fault("die", "", 0.1).success);
  step(12);
  EXPECT_TRUE(mortal.running()) << "not yet";
  StepSimulation more;
  more.request.steps = 24;
  EXPECT_FALSE(ros::service::call("sim/step", more)) << "nobody is left to answer";
  EXPECT_EQ(mortal.wait_for_end(), 1);
  (void)ros::param::del("/mortal");
}

}  // namespace
}  // namespace extperfc::ros_test
