// Topics, types, frames and rates; outputs without subscribers are not computed; pointers instead of copies.
#include <map>

#include <nav_msgs/Odometry.h>
#include <ros/master.h>
#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/PointCloud.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/Range.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <tf2_msgs/TFMessage.h>

#include "test/ros/simulator/simulator_test.hpp"
#include "test/ros/support/inbox.hpp"

namespace extperfc::ros_test {
namespace {

TEST_F(SimulatorTest, HasTheTopicsOfTheRealRobotAndItsSensors) {
  load(small_simulation());
  const std::map<std::string, std::string> wanted{
      {"/clock", "rosgraph_msgs/Clock"},
      {"/odom", "nav_msgs/Odometry"},
      {"/imu/data", "sensor_msgs/Imu"},
      {"/tf", "tf2_msgs/TFMessage"},
      {"/camera/color/image_raw", "sensor_msgs/Image"},
      {"/camera/color/camera_info", "sensor_msgs/CameraInfo"},
      {"/camera/aligned_depth_to_color/image_raw", "sensor_msgs/Image"},
      {"/camera/aligned_depth_to_color/camera_info", "sensor_msgs/CameraInfo"},
      {"/velodyne_points", "sensor_msgs/PointCloud2"},
      {"/robot/joint_states", "sensor_msgs/JointState"},
      {"/robot/state", "baxter_core_msgs/AssemblyState"},
      {"/robot/range/left_hand_range/state", "sensor_msgs/Range"},
      {"/robot/range/right_hand_range/state", "sensor_msgs/Range"},
      {"/robot/sonar/head_sonar/state", "sensor_msgs/PointCloud"},
      {"/sim/real_time_factor", "std_msgs/Float32"},
      {"/sim/truth/odom", "nav_msgs/Odometry"},
      {"/sim/truth/objects", "vision_msgs/Detection3DArray"},
      {"/sim/truth/map", "nav_msgs/OccupancyGrid"},
      {"/sim/truth/labels", "sensor_msgs/Image"},
      {"/sim/truth/detections", "vision_msgs/Detection2DArray"},
      {"/sim/truth/vision_info", "vision_msgs/VisionInfo"},
      {"/sim/world_markers", "visualization_msgs/MarkerArray"}};
  ros::master::V_TopicInfo topics;
  ASSERT_TRUE(ros::master::getTopics(topics));
  std::map<std::string, std::string> found;
  for (const auto& topic : topics) found[topic.name] = topic.datatype;
  for (const auto& [name, type] : wanted) EXPECT_EQ(found[name], type) << name;
}

TEST_F(SimulatorTest, RatesAreThoseOfTheRealSensorsInSimulatedTime) {
  const Inbox<rosgraph_msgs::Clock> clock("/clock");
  const Inbox<nav_msgs::Odometry> odom("odom");
  const Inbox<sensor_msgs::Imu> imu("imu/data");
  const Inbox<sensor_msgs::JointState> joints("robot/joint_states");
  const Inbox<sensor_msgs::Image> color("camera/color/image_raw");
  const Inbox<sensor_msgs::Image> depth("camera/aligned_depth_to_color/image_raw");
  const Inbox<sensor_msgs::CameraInfo> info("camera/color/camera_info");
  const Inbox<sensor_msgs::PointCloud2> cloud("velodyne_points");
  const Inbox<sensor_msgs::Range> range("robot/range/left_hand_range/state");
  const Inbox<sensor_msgs::PointCloud> sonar("robot/sonar/head_sonar/state");
  load(small_simulation());
  ASSERT_TRUE(wait_for([&] { return joints.connected() && color.connected() && cloud.connected(); }));
  const auto end = step(480);  // two seconds
  EXPECT_EQ(end, ros::Time(3.0)) << "the clock starts at 1 s";
  EXPECT_TRUE(wait_for([&] { return !clock.all().empty() && clock.all().back()->clock == end; }));
  EXPECT_TRUE(joints.wait_for_count(200));
  EXPECT_TRUE(imu.wait_for_count(200));
  EXPECT_TRUE(odom.wait_for_count(100));
  EXPECT_TRUE(range.wait_for_count(100));
  EXPECT_TRUE(color.wait_for_count(30));
  EXPECT_TRUE(depth.wait_for_count(30));
  EXPECT_TRUE(info.wait_for_count(30));
  EXPECT_TRUE(sonar.wait_for_count(20));
  EXPECT_TRUE(cloud.wait_for_count(19)) << "the first revolution only defines where the second begins";
  EXPECT_LE(joints.count(), 201U);
  EXPECT_EQ(imu.count(), 200U);
  EXPECT_EQ(odom.count(), 100U);
  EXPECT_EQ(color.count(), 30U);
  EXPECT_EQ(cloud.count(), 19U);
  EXPECT_GE(clock.count(), 240U);
  EXPECT_EQ(odom.all().back()->header.stamp, end);
  EXPECT_EQ(color.all().back()->header.stamp, end);
  EXPECT_EQ(depth.all().back()->header.stamp, end);
  EXPECT_EQ(info.all().back()->header.stamp, end);
}

TEST_F(SimulatorTest, CameraSpeaksAsTheRealSensesDriver) {
  const Inbox<sensor_msgs::Image> color("camera/color/image_raw");
  const Inbox<sensor_msgs::Image> depth("camera/aligned_depth_to_color/image_raw");
  const Inbox<sensor_msgs::CameraInfo> info("camera/aligned_depth_to_color/camera_info");
  load(small_simulation());
  ASSERT_TRUE(wait_for([&] { return color.connected() && depth.connected() && info.connected(); }));
  step(16);
  ASSERT_TRUE(color.wait_for_count(1) && depth.wait_for_count(1) && info.wait_for_count(1));
  const auto& image = *color.all().front();
  EXPECT_EQ(image.encoding, "rgb8");
  EXPECT_EQ(image.width, 64U);
  EXPECT_EQ(image.height, 48U);
  EXPECT_EQ(image.step, 192U);
  EXPECT_EQ(image.data.size(), 192U * 48U);
  EXPECT_EQ(image.header.frame_id, "camera_color_optical_frame");
  EXPECT_EQ(depth.all().front()->encoding, "16UC1");
  EXPECT_EQ(depth.all().front()->data.size(), 64U * 48U * 2U);
  EXPECT_EQ(depth.all().front()->header.stamp, image.header.stamp);
  EXPECT_DOUBLE_EQ(info.all().front()->K[0], 61.5) << "615 px at 640 pixels width";
  EXPECT_EQ(info.all().front()->header.stamp, image.header.stamp);
}

TEST_F(SimulatorTest, DepthInMetresOnDemand) {
  const Inbox<sensor_msgs::Image> depth("camera/aligned_depth_to_color/image_raw");
  load(with(small_simulation(), {{"camera/depth_encoding", std::string("32FC1")}}));
  ASSERT_TRUE(wait_for([&] { return depth.connected(); }));
  step(16);
  ASSERT_TRUE(depth.wait_for_count(1));
  const auto& image = *depth.all().front();
  EXPECT_EQ(image.encoding, "32FC1");
  ASSERT_EQ(image.data.size(), 64U * 48U * sizeof(float));
  const auto* metres = reinterpret_cast<const float*>(image.data.data());
  const auto good = std::count_if(metres, metres + 64 * 48, [](float z) { return z > 0.1F && z < 10.0F; });
  const auto none = std::count_if(metres, metres + 64 * 48, [](float z) { return std::isnan(z); });
  EXPECT_GT(good, 64 * 48 / 2);
  EXPECT_EQ(good + none, 64 * 48) << "a value or NaN";
}

TEST_F(SimulatorTest, CloudHasTheFieldsOfTheVelodyneDriver) {
  const Inbox<sensor_msgs::PointCloud2> cloud("velodyne_points");
  load(small_simulation());
  ASSERT_TRUE(wait_for([&] { return cloud.connected(); }));
  step(48);
  ASSERT_TRUE(cloud.wait_for_count(1));
  const auto& sweep = *cloud.all().front();
  EXPECT_EQ(sweep.header.frame_id, "velodyne");
  EXPECT_EQ(sweep.point_step, 22U);
  EXPECT_GT(sweep.width, 90U * 16U / 2);
  EXPECT_LE(sweep.width, 90U * 16U);
  sensor_msgs::PointCloud2ConstIterator<std::uint16_t> ring(sweep, "ring");
  sensor_msgs::PointCloud2ConstIterator<float> time(sweep, "time");
  for (; ring != ring.end(); ++ring, ++time) {
    ASSERT_LT(*ring, 16);
    ASSERT_LE(*time, 0.0F);
    ASSERT_GT(*time, -0.1001F);
  }
}

TEST_F(SimulatorTest, FramesLeadFromTheMapToTheRobot) {
  const Inbox<tf2_msgs::TFMessage> tf("/tf");
  load(with(small_simulation(), {{"base/publish_map_frame", true}}));
  ASSERT_TRUE(wait_for([&] { return tf.connected(); }));
  step(24);
  std::map<std::string, geometry_msgs::TransformStamped> frames;
  ASSERT_TRUE(wait_for([&] {
    for (const auto& message : tf.all())
      for (const auto& one : message->transforms)
        frames[one.header.frame_id + ">" + one.child_frame_id] = one;
    return frames.count("map>odom") > 0 && frames.count("odom>base_footprint") > 0;
  }));
  EXPECT_NEAR(frames["map>odom"].transform.translation.x, -1.0, 0.01) << "where the world puts the robot";
  EXPECT_NEAR(frames["odom>base_footprint"].transform.translation.x, 0.0, 0.01);
}

TEST_F(SimulatorTest, TheMapFrameIsLeftToALocalizer) {
  const Inbox<tf2_msgs::TFMessage> tf("/tf");
  load(small_simulation());
  ASSERT_TRUE(wait_for([&] { return tf.connected(); }));
  step(24);
  ASSERT_TRUE(tf.wait_for_count(4));
  for (const auto& message : tf.all())
    for (const auto& one : message->transforms) EXPECT_NE(one.child_frame_id, "odom");
}

/// What a sensor's diagnostics say under `key`.
class SensorDiagnostics {
 public:
  explicit SensorDiagnostics(std::string sensor) : name_("simulator: " + std::move(sensor)) {}
  [[nodiscard]] std::string latest(const std::string& key) const {
    std::string value;
    for (const auto& array : inbox_.all())
      for (const auto& status : array->status)
        if (status.name == name_)
          for (const auto& pair : status.values)
            if (pair.key == key) value = pair.value;
    return value;
  }
  void forget() { inbox_.clear(); }

 private:
  std::string name_;
  Inbox<diagnostic_msgs::DiagnosticArray> inbox_{"/diagnostics"};
};

TEST_F(SimulatorTest, NothingIsRenderedWithoutSubscribers) {
  SensorDiagnostics camera("camera");
  const SensorDiagnostics lidar("lidar");
  load(small_simulation());
  step(240);
  camera.forget();
  ASSERT_TRUE(wait_for(
      [&] { return !camera.latest("images rendered").empty() && !lidar.latest("processed").empty(); }));
  EXPECT_EQ(camera.latest("images rendered"), "0");
  EXPECT_EQ(lidar.latest("processed"), "0");
  {
    const Inbox<sensor_msgs::CameraInfo> info("camera/color/camera_info");
    ASSERT_TRUE(wait_for([&] { return info.connected(); }));
    step(240);
    EXPECT_TRUE(info.wait_for_count(15)) << "camera info costs nothing";
  }
  camera.forget();
  ASSERT_TRUE(wait_for([&] { return !camera.latest("images rendered").empty(); }));
  EXPECT_EQ(camera.latest("images rendered"), "0");
  const Inbox<sensor_msgs::Image> depth("camera/aligned_depth_to_color/image_raw");
  ASSERT_TRUE(wait_for([&] { return depth.connected(); }));
  step(240);
  EXPECT_TRUE(depth.wait_for_count(15));
  EXPECT_TRUE(wait_for([&] { return camera.latest("images rendered") == "15"; }));
}

TEST_F(SimulatorTest, ImagesTravelAsPointers) {
  const SensorDiagnostics camera("camera");
  const Inbox<sensor_msgs::Image> color("camera/color/image_raw");
  const Inbox<sensor_msgs::Image> depth("camera/aligned_depth_to_color/image_raw");
  load(small_simulation());
  ASSERT_TRUE(wait_for([&] { return color.connected() && depth.connected(); }));
  for (std::size_t i = 1; i <= 3; ++i) {
    step(16);
    ASSERT_TRUE(color.wait_for_count(i) && depth.wait_for_count(i));
    const auto place = [](const sensor_msgs::Image& image) {
      return stamp_text(image.header.stamp) + " @ " + address_text(image.data.data());
    };
    EXPECT_TRUE(wait_for([&] { return camera.latest("color last") == place(*color.all().back()); }))
        << camera.latest("color last");
    EXPECT_TRUE(wait_for([&] { return camera.latest("depth last") == place(*depth.all().back()); }));
  }
}

}  // namespace
}  // namespace extperfc::ros_test
