#pragma once

#include <cmath>
#include <string>

#include <extperfc/EnrollFace.h>
#include <extperfc/FaceArray.h>
#include <extperfc/ForgetFace.h>
#include <gtest/gtest.h>
#include <ros/service.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include "extperfc/base/rng.hpp"

#include "test/ros/support/images.hpp"
#include "test/ros/support/inbox.hpp"
#include "test/ros/support/manager.hpp"
#include "test/ros/support/watch.hpp"

namespace extperfc::ros_test {

inline const cv::Size kFacesSize{320, 320};  ///< of the model `red_nose`, so that boxes are exact
constexpr int kCellPx = 32;

/// A cell of the model `red_nose`.
struct Cell {
  int column, row;
};

/// The box of a face with its nose in a cell.
inline cv::Rect face_box(const Cell& nose) {
  return {(nose.column - 1) * kCellPx, (nose.row - 1) * kCellPx, 3 * kCellPx, 3 * kCellPx};
}

/// Draws stripes, in squares of 16 pixels with a random direction each, which are a person's face, with a red
/// nose.
inline void draw_person(cv::Mat3b& rgb, int person, const Cell& nose) {
  constexpr int kSquarePx = 16;
  Rng rng(static_cast<std::uint64_t>(person));
  const auto box = face_box(nose);
  for (int top = 0; top < box.height; top += kSquarePx)
    for (int left = 0; left < box.width; left += kSquarePx) {
      const bool is_nose = top / kCellPx == 1 && left / kCellPx == 1;
      const double angle = rng.uniform(-M_PI, M_PI);
      for (int i = 0; i < kSquarePx * kSquarePx; ++i) {
        const int x = left + i % kSquarePx;
        const int y = top + i / kSquarePx;
        const double stripes = std::sin(0.8 * (x * std::cos(angle) + y * std::sin(angle)));
        const auto value = static_cast<std::uint8_t>(110 + 50 * stripes);
        const auto pale = static_cast<std::uint8_t>(value / 4);
        rgb(box.y + y, box.x + x) = is_nose ? cv::Vec3b(240, pale, pale) : cv::Vec3b(value, value, value);
      }
    }
}

/// One person; 0: an empty room.
inline sensor_msgs::ImagePtr image_of(int person, const ros::Time& stamp, const Cell& nose = {5, 4}) {
  cv::Mat3b rgb(kFacesSize, cv::Vec3b(60, 60, 60));
  if (person != 0) draw_person(rgb, person, nose);
  return to_image(rgb, "rgb8", stamp);
}

/// The nodelet `extperfc/faces` with subscribers; the test plays the camera.
class FacesTest : public testing::Test {
 protected:
  [[nodiscard]] static Params faces_params(const Params& more = {}) {
    Params params{{"model", model_folder("red_nose")}, {"backend", "opencv"}, {"threads", 1}};
    for (const auto& [key, value] : more) params[key] = value;
    return params;
  }

  void load(const Params& more = {}) {
    ASSERT_TRUE(manager_.load("/faces", "faces", faces_params(more))) << log_.text();
    ASSERT_TRUE(wait_for([this] { return images_.getNumSubscribers() > 0 && faces_.connected(); }));
  }

  /// What the nodelet makes of an image; null when it does not answer.
  [[nodiscard]] FaceArrayConstPtr answer_to(const sensor_msgs::ImageConstPtr& image) const {
    images_.publish(image);
    return faces_.wait_for_stamp(image->header.stamp);
  }

  /// The name of the one face in an image of a person.
  [[nodiscard]] std::string name_of(int person, const ros::Time& stamp) const {
    const auto answer = answer_to(image_of(person, stamp));
    if (!answer || answer->faces.size() != 1) return "not one face";
    return answer->faces.front().name;
  }

  ros::NodeHandle handle_;
  ros::Publisher images_{handle_.advertise<sensor_msgs::Image>("camera/color/image_raw", 10)};
  ros::Publisher depth_{handle_.advertise<sensor_msgs::Image>("camera/aligned_depth_to_color/image_raw", 10)};
  ros::Publisher info_{handle_.advertise<sensor_msgs::CameraInfo>("camera/color/camera_info", 10)};
  Inbox<FaceArray> faces_{"faces"};
  DiagnosticsWatch diagnostics_{"faces"};
  LogWatch log_;
  Manager manager_;
};

}  // namespace extperfc::ros_test
