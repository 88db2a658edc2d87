// What box_depth says when its inputs do not fit together, and that it goes on when they do again.
#include <vision_msgs/VisionInfo.h>

#include "test/ros/box_depth_test.hpp"
#include "test/ros/support/simulated_time.hpp"

namespace extperfc::ros_test {
namespace {

class BoxDepthFaultTest : public BoxDepthTest {
 protected:
  /// Nothing is published, diagnostics say why, and the log says it once.
  void expect_error(const std::string& text) {
    EXPECT_TRUE(diagnostics_.wait([&](const Report& r) { return r.is_error_about(text); }))
        << "wanted '" << text << "', diagnostics say '" << diagnostics_.latest().message() << "'";
    EXPECT_EQ(objects_.count(), 0U);
    EXPECT_TRUE(log_.wait(text)) << log_.text();
    EXPECT_EQ(log_.count(text), 1U) << log_.text();
  }

  void expect_recovery(const ros::Time& stamp) {
    const auto message = locate(stamp, 1.5);
    ASSERT_TRUE(message) << diagnostics_.latest().message();
    EXPECT_EQ(message->detections.size(), 1U);
    EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.level() == 0; }))
        << diagnostics_.latest().message();
  }

  void send_pair(const sensor_msgs::ImageConstPtr& depth) const {
    depth_.publish(depth);
    detections_.publish(boxes_at(depth->header.stamp, {kSquare}));
  }
};

TEST_F(BoxDepthFaultTest, NoCameraInfo) {
  load();
  send_pair(depth_image(3.0, 1.5, kSquare, "16UC1", ros::Time(1, 0)));
  expect_error("no camera info on /camera/color/camera_info yet");
  send_info(camera_info(ros::Time(2, 0)));
  expect_recovery(ros::Time(2, 0));
}

TEST_F(BoxDepthFaultTest, CameraInfoOfAnotherSize) {
  load();
  send_info(camera_info(ros::Time(1, 0), {640, 480}));
  send_pair(depth_image(3.0, 1.5, kSquare, "16UC1", ros::Time(1, 0)));
  expect_error("camera info is for 640 x 480 pixels, but the depth image has 320 x 240");
  send_info(camera_info(ros::Time(2, 0)));
  expect_recovery(ros::Time(2, 0));
}

TEST_F(BoxDepthFaultTest, DepthOfAnotherSizeThanColour) {
  load();
  send_info(camera_info(ros::Time(1, 0)));
  send_pair(depth_image(3.0, 1.5, kSquare, "16UC1", ros::Time(1, 0), {424, 240}));
  expect_error("camera info is for 320 x 240 pixels, but the depth image has 424 x 240");
  expect_recovery(ros::Time(2, 0));
}

TEST_F(BoxDepthFaultTest, CameraInfoThatIsNotCalibrated) {
  load();
  auto info = camera_info(ros::Time(1, 0));
  info->K.fill(0.0);
  send_info(info);
  send_pair(depth_image(3.0, 1.5, kSquare, "16UC1", ros::Time(1, 0)));
  expect_error("fx");
}

TEST_F(BoxDepthFaultTest, ColourOnTheDepthTopic) {
  load();
  send_info(camera_info(ros::Time(1, 0)));
  send_pair(to_image(draw_square(kRed), "rgb8", ros::Time(1, 0)));
  expect_error("depth: encoding 'rgb8' is not depth; use 16UC1 [mm] or 32FC1 [m]");
  expect_recovery(ros::Time(2, 0));
}

TEST_F(BoxDepthFaultTest, DepthImageIsCutOff) {
  load();
  send_info(camera_info(ros::Time(1, 0)));
  auto depth = depth_image(3.0, 1.5, kSquare, "16UC1", ros::Time(1, 0));
  depth->data.resize(100);
  send_pair(depth);
  expect_error("but the message has 100");
  expect_recovery(ros::Time(2, 0));
}

TEST_F(BoxDepthFaultTest, TransformIsMissing) {
  load({{"target_frame", "moon"}, {"transform_timeout_s", 0.0}});
  send_info(camera_info(ros::Time(1, 0)));
  send_pair(depth_image(3.0, 1.5, kSquare, "16UC1", ros::Time(1, 0)));
  expect_error("no transform from camera_color_optical_frame to moon");
}

TEST_F(BoxDepthFaultTest, ImageWithoutAFrame) {
  load({{"target_frame", "base_link"}, {"transform_timeout_s", 0.0}});
  send_info(camera_info(ros::Time(1, 0)));
  auto depth = depth_image(3.0, 1.5, kSquare, "16UC1", ros::Time(1, 0));
  depth->header.frame_id.clear();
  send_pair(depth);
  expect_error("no transform from  to base_link");
}

TEST_F(BoxDepthFaultTest, StampsNeverMatch) {
  load();
  send_info(camera_info(ros::Time(1, 0)));
  for (int i = 1; i <= 10; ++i) {
    depth_.publish(depth_image(3.0, 1.5, kSquare, "16UC1", ros::Time(i, 0)));
    detections_.publish(boxes_at(ros::Time(i, 500000000), {kSquare}));
  }
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) {
    return r.is_warning_about("/camera/aligned_depth_to_color/image_raw has no image within 0.020 s");
  })) << diagnostics_.latest().message();
  EXPECT_EQ(objects_.count(), 0U);
  expect_recovery(ros::Time(20, 0));
}

TEST_F(BoxDepthFaultTest, WithinToleranceTheyMatch) {
  load({{"stamp_tolerance_s", 0.1}});
  send_info(camera_info(ros::Time(1, 0)));
  depth_.publish(depth_image(3.0, 1.5, kSquare, "16UC1", ros::Time(1, 90000000)));
  detections_.publish(boxes_at(ros::Time(1, 0), {kSquare}));
  EXPECT_TRUE(objects_.wait_for_stamp(ros::Time(1, 0))) << "a result keeps the stamp of its detections";
}

TEST_F(BoxDepthFaultTest, ATopicThatStops) {
  load({{"timeout_s", 0.5}});
  send_info(camera_info(ros::Time(1, 0)));
  // Detections go on, depth does not.
  std::uint32_t second = 1;
  EXPECT_TRUE(wait_for([&] {
    detections_.publish(boxes_at(ros::Time(++second, 0), {}));
    info_.publish(camera_info(ros::Time(second, 0)));
    return diagnostics_.latest().message().find(
               "no message on /camera/aligned_depth_to_color/image_raw for") != std::string::npos;
  })) << diagnostics_.latest().message();
  EXPECT_EQ(diagnostics_.latest().level(), 1);
}

TEST_F(BoxDepthFaultTest, ClassNamesWhoseLocationIsNoParameter) {
  auto vision_info = handle_.advertise<vision_msgs::VisionInfo>("vision_info", 1, true);
  vision_msgs::VisionInfo elsewhere;
  elsewhere.database_location = "https://example.org/my classes.json";
  vision_info.publish(elsewhere);
  load();
  ASSERT_TRUE(wait_for([&] { return vision_info.getNumSubscribers() > 0; }));
  elsewhere.database_location = "";
  vision_info.publish(elsewhere);
  send_info(camera_info(ros::Time(1, 0)));
  expect_recovery(ros::Time(1, 0));
}

TEST_F(BoxDepthFaultTest, StampFromTheEndOfTime) {
  load({{"target_frame", kFrame}});
  send_info(camera_info(ros::Time(1, 0)));
  expect_recovery(ros::Time(4294967295U, 0));
  expect_recovery(ros::Time(3, 0));
}

TEST_F(BoxDepthFaultTest, DiagnosticsGoOnAfterTheClockRanBack) {
  load();
  ASSERT_TRUE(diagnostics_.goes_on());
  const SimulatedTime earlier(10.0);
  EXPECT_TRUE(diagnostics_.goes_on()) << "not only when the time of before is reached";
}

TEST_F(BoxDepthFaultTest, HypothesesAndBoxesThatAreNoNumbers) {
  load();
  send_info(camera_info(ros::Time(1, 0)));
  auto boxes = boxes_at(ros::Time(1, 0), {kSquare, kSquare, kSquare});
  boxes->detections[0].bbox.center.x = std::numeric_limits<double>::quiet_NaN();
  boxes->detections[1].bbox.size_x = std::numeric_limits<double>::infinity();
  boxes->detections[2].results.clear();
  depth_.publish(depth_image(3.0, 1.5, kSquare, "16UC1", ros::Time(1, 0)));
  detections_.publish(boxes);
  const auto message = objects_.wait_for_stamp(ros::Time(1, 0));
  ASSERT_TRUE(message);
  ASSERT_EQ(message->detections.size(), 1U);
  EXPECT_EQ(message->detections.front().results.front().id, -1) << "a box without a hypothesis has no class";
}

TEST_F(BoxDepthFaultTest, IsUnloadedWhilePairsStream) {
  for (int round = 0; round < 10; ++round) {
    load();
    for (int i = 1; i <= 5; ++i) {
      info_.publish(camera_info(ros::Time::now()));
      send_pair(depth_image(3.0, 1.5, kSquare, "16UC1", ros::Time::now()));
    }
    manager_.unload("/box_depth");
    ASSERT_TRUE(wait_for([this] { return detections_.getNumSubscribers() == 0; }));
  }
}

}  // namespace
}  // namespace extperfc::ros_test
