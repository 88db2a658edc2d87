#include "test/ros/support/images.hpp"

#include <stdexcept>

#include <boost/make_shared.hpp>
#include <cv_bridge/cv_bridge.h>
#include <opencv2/imgproc.hpp>

namespace extperfc::ros_test {

namespace {

/// Which colour a Bayer sensor sees at a pixel: "bayer_rggb8" names the first row's pair and the second
/// row's.
cv::Mat1b bayer(const cv::Mat3b& rgb, const std::string& encoding) {
  const std::string pattern = encoding.substr(6, 4);
  cv::Mat1b mosaic(rgb.size());
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      const char letter = pattern[static_cast<std::size_t>(2 * (y % 2) + x % 2)];
      mosaic(y, x) = rgb(y, x)[letter == 'r' ? 0 : letter == 'g' ? 1 : 2];
    }
  return mosaic;
}

/// U Y V Y of each pair of pixels, or Y U Y V.
cv::Mat2b yuv422(const cv::Mat3b& rgb, bool luminance_first) {
  cv::Mat3b yuv;
  cv::cvtColor(rgb, yuv, cv::COLOR_RGB2YCrCb);  // y, v, u
  cv::Mat2b packed(rgb.size());
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      const auto chroma = yuv(y, x - x % 2)[x % 2 == 0 ? 2 : 1];
      const auto luminance = yuv(y, x)[0];
      packed(y, x) = luminance_first ? cv::Vec2b(luminance, chroma) : cv::Vec2b(chroma, luminance);
    }
  return packed;
}

cv::Mat encode(const cv::Mat3b& rgb, const std::string& encoding) {
  cv::Mat out;
  if (encoding == "rgb8") return rgb;
  if (encoding.rfind("bayer_", 0) == 0) return bayer(rgb, encoding);
  if (encoding == "yuv422" || encoding == "yuv422_yuy2") return yuv422(rgb, encoding == "yuv422_yuy2");
  if (encoding == "bgr8") cv::cvtColor(rgb, out, cv::COLOR_RGB2BGR);
  if (encoding == "rgba8") cv::cvtColor(rgb, out, cv::COLOR_RGB2RGBA);
  if (encoding == "bgra8") cv::cvtColor(rgb, out, cv::COLOR_RGB2BGRA);
  if (encoding == "mono8" || encoding == "mono16") cv::cvtColor(rgb, out, cv::COLOR_RGB2GRAY);
  if (encoding == "mono16") out.convertTo(out, CV_16U, 257.0);
  if (out.empty()) throw std::invalid_argument("the tests cannot draw " + encoding);
  return out;
}

std_msgs::Header header_at(const ros::Time& stamp) {
  std_msgs::Header header;
  header.stamp = stamp;
  header.frame_id = kFrame;
  return header;
}

}  // namespace

cv::Mat3b draw_square(const cv::Vec3b& color, const cv::Rect& where) {
  cv::Mat3b rgb(kSize, cv::Vec3b(10, 10, 10));
  rgb(where).setTo(cv::Scalar(color[0], color[1], color[2]));
  return rgb;
}

sensor_msgs::ImagePtr to_image(const cv::Mat3b& rgb, const std::string& encoding, const ros::Time& stamp) {
  const cv::Mat pixels = encode(rgb, encoding);
  auto message = boost::make_shared<sensor_msgs::Image>();
  message->header = header_at(stamp);
  message->width = static_cast<std::uint32_t>(pixels.cols);
  message->height = static_cast<std::uint32_t>(pixels.rows);
  message->encoding = encoding;
  message->step = static_cast<std::uint32_t>(pixels.cols * pixels.elemSize());
  message->data.assign(pixels.datastart, pixels.dataend);
  return message;
}

sensor_msgs::ImagePtr depth_image(double wall_m, double box_m, const cv::Rect& box,
                                  const std::string& encoding, const ros::Time& stamp, const cv::Size& size) {
  cv::Mat depth(size, CV_32FC1, cv::Scalar(wall_m));
  depth(box).setTo(box_m);
  if (encoding == "16UC1") depth.convertTo(depth, CV_16U, 1000.0);
  return cv_bridge::CvImage(header_at(stamp), encoding, depth).toImageMsg();
}

sensor_msgs::CameraInfoPtr camera_info(const ros::Time& stamp, const cv::Size& size) {
  auto info = boost::make_shared<sensor_msgs::CameraInfo>();
  info->header = header_at(stamp);
  info->width = static_cast<std::uint32_t>(size.width);
  info->height = static_cast<std::uint32_t>(size.height);
  const double cx = 0.5 * (size.width - 1);
  const double cy = 0.5 * (size.height - 1);
  info->K = {kFocalPx, 0, cx, 0, kFocalPx, cy, 0, 0, 1};
  info->P = {kFocalPx, 0, cx, 0, 0, kFocalPx, cy, 0, 0, 0, 1, 0};
  return info;
}

}  // namespace extperfc::ros_test
