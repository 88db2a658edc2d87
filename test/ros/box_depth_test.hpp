#pragma once

#include <string>
#include <vector>

#include <geometry_msgs/PoseWithCovariance.h>
#include <gtest/gtest.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <vision_msgs/Detection2DArray.h>
#include <vision_msgs/Detection3DArray.h>
#include <visualization_msgs/MarkerArray.h>

#include "test/ros/support/images.hpp"
#include "test/ros/support/inbox.hpp"
#include "test/ros/support/manager.hpp"
#include "test/ros/support/watch.hpp"

namespace extperfc::ros_test {

constexpr const char* kDetectionsTopic = "detections";
constexpr const char* kDepthTopic = "camera/aligned_depth_to_color/image_raw";
constexpr const char* kInfoTopic = "camera/color/camera_info";

/// Boxes of class 1, score 0.9.
[[nodiscard]] inline vision_msgs::Detection2DArrayPtr boxes_at(const ros::Time& stamp,
                                                               const std::vector<cv::Rect>& boxes) {
  auto message = boost::make_shared<vision_msgs::Detection2DArray>();
  message->header.stamp = stamp;
  message->header.frame_id = kFrame;
  for (const auto& box : boxes) {
    vision_msgs::Detection2D detection;
    detection.header = message->header;
    detection.bbox.center.x = box.x + 0.5 * box.width;
    detection.bbox.center.y = box.y + 0.5 * box.height;
    detection.bbox.size_x = box.width;
    detection.bbox.size_y = box.height;
    detection.results.resize(1);
    detection.results[0].id = 1;
    detection.results[0].score = 0.9;
    message->detections.push_back(detection);
  }
  return message;
}

/// box_depth with somebody who wants its results; the test plays detector and camera.
class BoxDepthTest : public testing::Test {
 protected:
  void load(const Params& params = {}) {
    ASSERT_TRUE(manager_.load("/box_depth", "box_depth", params)) << log_.text();
    ASSERT_TRUE(wait_for([this] {
      return detections_.getNumSubscribers() > 0 && depth_.getNumSubscribers() > 0 &&
             info_.getNumSubscribers() > 0 && objects_.connected() && surface_.connected();
    }));
  }

  /// Sends the intrinsics and waits until they have arrived: topics overtake each other.
  void send_info(const sensor_msgs::CameraInfoConstPtr& info) const {
    const long before = std::max(0L, diagnostics_.latest().number("camera info received"));
    info_.publish(info);
    ASSERT_TRUE(
        diagnostics_.wait_latest([&](const Report& r) { return r.number("camera info received") > before; }));
  }

  /// The surface points that belong to `objects`: one for each.
  [[nodiscard]] std::vector<geometry_msgs::PoseWithCovariance> surface_of(
      const vision_msgs::Detection3DArray& objects) const {
    const auto message = surface_.wait_for_stamp(objects.header.stamp);
    EXPECT_TRUE(message);
    if (!message) return std::vector<geometry_msgs::PoseWithCovariance>(objects.detections.size());
    EXPECT_EQ(message->header, objects.header);
    EXPECT_EQ(message->detections.size(), objects.detections.size());
    std::vector<geometry_msgs::PoseWithCovariance> points;
    for (const auto& detection : message->detections) {
      EXPECT_EQ(detection.results.size(), 1U);
      EXPECT_EQ(detection.results.front().pose.pose, detection.bbox.center);
      points.push_back(detection.results.front().pose);
    }
    return points;
  }

  /// One box before a wall at 3 m. Null when no result comes.
  vision_msgs::Detection3DArrayConstPtr locate(const ros::Time& stamp, double box_m,
                                               const std::string& encoding = "16UC1") {
    depth_.publish(depth_image(3.0, box_m, kSquare, encoding, stamp));
    detections_.publish(boxes_at(stamp, {kSquare}));
    return objects_.wait_for_stamp(stamp);
  }

  ros::NodeHandle handle_;
  ros::Publisher detections_{handle_.advertise<vision_msgs::Detection2DArray>(kDetectionsTopic, 10)};
  ros::Publisher depth_{handle_.advertise<sensor_msgs::Image>(kDepthTopic, 10)};
  ros::Publisher info_{handle_.advertise<sensor_msgs::CameraInfo>(kInfoTopic, 10)};
  Inbox<vision_msgs::Detection3DArray> objects_{"detections_3d"};
  Inbox<vision_msgs::Detection3DArray> surface_{"detections_3d/surface"};
  DiagnosticsWatch diagnostics_{"box_depth"};
  LogWatch log_;
  Manager manager_;
};

}  // namespace extperfc::ros_test
