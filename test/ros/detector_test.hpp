#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sensor_msgs/Image.h>
#include <vision_msgs/Detection2DArray.h>

#include "test/ros/support/images.hpp"
#include "test/ros/support/inbox.hpp"
#include "test/ros/support/manager.hpp"
#include "test/ros/support/watch.hpp"

namespace extperfc::ros_test {

/// A detector with the model `square` and the topics around it; the test plays the camera.
class DetectorTest : public testing::Test {
 protected:
  static constexpr const char* kTopic = "camera/color/image_raw";

  void load(const Params& more = {}, const std::string& model = "square") {
    Params params = detector_params(model);
    for (const auto& [key, value] : more) params[key] = value;
    ASSERT_TRUE(manager_.load("/detector", "detector", params)) << log_.text();
  }

  [[nodiscard]] bool detector_listens() const { return images_.getNumSubscribers() > 0; }

  void send(const sensor_msgs::ImageConstPtr& image) const { images_.publish(image); }

  ros::Publisher images_{ros::NodeHandle().advertise<sensor_msgs::Image>(kTopic, 100)};
  DiagnosticsWatch diagnostics_{"detector"};
  LogWatch log_;
  Manager manager_;
};

/// The same, with somebody who wants detections.
class ListeningDetectorTest : public DetectorTest {
 protected:
  void load_and_listen(const Params& more = {}, const std::string& model = "square") {
    load(more, model);
    ASSERT_TRUE(wait_for([this] { return detector_listens() && detections_.connected(); }));
  }

  /// What the detector makes of an image; null when it does not answer.
  [[nodiscard]] vision_msgs::Detection2DArrayConstPtr answer_to(
      const sensor_msgs::ImageConstPtr& image) const {
    send(image);
    return detections_.wait_for_stamp(image->header.stamp);
  }

  Inbox<vision_msgs::Detection2DArray> detections_{"detections"};
};

}  // namespace extperfc::ros_test
