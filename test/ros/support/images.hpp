#pragma once

#include <string>

#include <opencv2/core.hpp>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

namespace extperfc::ros_test {

constexpr const char* kFrame = "camera_color_optical_frame";
inline const cv::Size kSize{320, 240};  ///< of every image, unless a test says otherwise
inline const cv::Rect kSquare{80, 60, 80,
                              60};         ///< whole cells of the model `square`, so that its box is exact
inline const cv::Vec3b kRed{230, 20, 20};  ///< r, g, b
inline const cv::Vec3b kGreen{20, 230, 20};
inline const cv::Vec3b kBlue{20, 20, 230};
inline const cv::Vec3b kWhite{240, 240, 240};
constexpr double kFocalPx = 300.0;

/// Index of the model's class, in the order of its model.yaml.
enum SquareClass { kClassRed, kClassGreen, kClassBlue, kClassWhite };

/// A dark image with one square, RGB.
[[nodiscard]] cv::Mat3b draw_square(const cv::Vec3b& color, const cv::Rect& where = kSquare);

/// The image as a camera of this encoding would send it.
[[nodiscard]] sensor_msgs::ImagePtr to_image(const cv::Mat3b& rgb, const std::string& encoding,
                                             const ros::Time& stamp);

/// A wall with a nearer box in front of it [m]; `encoding` is 16UC1 or 32FC1. 0 = no measurement.
[[nodiscard]] sensor_msgs::ImagePtr depth_image(double wall_m, double box_m, const cv::Rect& box,
                                                const std::string& encoding, const ros::Time& stamp,
                                                const cv::Size& size = kSize);

/// Intrinsics of the test camera: kFocalPx, the middle of the image, no distortion.
[[nodiscard]] sensor_msgs::CameraInfoPtr camera_info(const ros::Time& stamp, const cv::Size& size = kSize);

}  // namespace extperfc::ros_test
