#include "ros/convert/image.hpp"

#include <algorithm>
#include <string>

#include <sensor_msgs/distortion_models.h>

namespace extperfc::ros_convert {

namespace {

std::string size_text(unsigned width, unsigned height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

Result<void> check_layout(const sensor_msgs::Image& message, PixelFormat format) {
  if (message.width == 0 || message.height == 0 || message.data.empty())
    return fail(ErrorCode::kInvalidArgument, "the image is empty (" +
                                                 size_text(message.width, message.height) + ", " +
                                                 std::to_string(message.data.size()) + " bytes)");
  const std::size_t row_bytes = static_cast<std::size_t>(message.width) * bytes_per_pixel(format);
  if (message.step < row_bytes)
    return fail(ErrorCode::kInvalidArgument, "a row of " + std::to_string(message.width) + " pixels of '" +
                                                 message.encoding + "' needs " + std::to_string(row_bytes) +
                                                 " bytes, but the message's step is " +
                                                 std::to_string(message.step));
  if (message.data.size() < static_cast<std::size_t>(message.step) * message.height)
    return fail(ErrorCode::kInvalidArgument,
                "an image of " + size_text(message.width, message.height) + " with step " +
                    std::to_string(message.step) + " needs " +
                    std::to_string(static_cast<std::size_t>(message.step) * message.height) +
                    " bytes, but the message has " + std::to_string(message.data.size()));
  return {};
}

/// As cv_bridge::toCvShare, which knows every encoding but the newest one, yuv422_yuy2.
cv_bridge::CvImageConstPtr wrap(const sensor_msgs::ImageConstPtr& message, PixelFormat format) {
  if (format != PixelFormat::kYuv422Yuy2) return cv_bridge::toCvShare(message);
  const cv::Mat pixels(static_cast<int>(message->height), static_cast<int>(message->width), CV_8UC2,
                       const_cast<std::uint8_t*>(message->data.data()),
                       message->step);  // cv::Mat knows no const
  return {new cv_bridge::CvImage(message->header, message->encoding, pixels),
          [message](const cv_bridge::CvImage* image) { delete image; }};
}

}  // namespace

Result<SharedImage> share_image(const sensor_msgs::ImageConstPtr& message) {
  const auto format = pixel_format_from_encoding(message->encoding);
  if (!format)
    return fail(
        ErrorCode::kUnsupported,
        "encoding '" + message->encoding +
            "' is not supported; use rgb8, bgr8, rgba8, bgra8, mono8, mono16, bayer_*8, yuv422, yuv422_yuy2, "
            "or 16UC1 and 32FC1 for depth");
  if (auto fits = check_layout(*message, *format); !fits) return tl::unexpected(fits.error());
  try {
    SharedImage shared{wrap(message, *format), {}};
    const cv::Mat& mat = shared.holder->image;
    shared.view = {mat.data, mat.cols, mat.rows, mat.step[0], *format};
    return shared;
  } catch (const std::exception& error) {  // cv_bridge and OpenCV both throw
    return fail(ErrorCode::kUnsupported, std::string("cv_bridge cannot wrap the image: ") + error.what());
  }
}

Result<CameraModel> to_camera_model(const sensor_msgs::CameraInfo& info) {
  CameraModel camera{static_cast<int>(info.width),
                     static_cast<int>(info.height),
                     info.K[0],
                     info.K[4],
                     info.K[2],
                     info.K[5],
                     {}};
  const bool distorted = std::any_of(info.D.begin(), info.D.end(), [](double k) { return k != 0.0; });
  if (distorted) {
    if (info.distortion_model != sensor_msgs::distortion_models::PLUMB_BOB ||
        info.D.size() > camera.distortion.size())
      return fail(ErrorCode::kUnsupported,
                  "distortion model '" + info.distortion_model + "' with " + std::to_string(info.D.size()) +
                      " coefficients is not supported; use plumb_bob or rectified images");
    std::copy(info.D.begin(), info.D.end(), camera.distortion.begin());
  }
  if (auto valid = camera.validate(); !valid) return tl::unexpected(valid.error());
  return camera;
}

sensor_msgs::CameraInfo to_camera_info(const CameraModel& camera, const std_msgs::Header& header) {
  sensor_msgs::CameraInfo info;
  info.header = header;
  info.width = static_cast<std::uint32_t>(camera.width);
  info.height = static_cast<std::uint32_t>(camera.height);
  info.distortion_model = sensor_msgs::distortion_models::PLUMB_BOB;
  info.D.assign(camera.distortion.begin(), camera.distortion.end());
  info.K = {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
  info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.P = {camera.fx, 0, camera.cx, 0, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0};
  return info;
}

}  // namespace extperfc::ros_convert
