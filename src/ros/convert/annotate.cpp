#include "ros/convert/annotate.hpp"

#include <algorithm>
#include <string>

#include <opencv2/imgproc.hpp>
#include <sensor_msgs/image_encodings.h>

#include "ros/convert/detections.hpp"

namespace extperfc::ros_convert {

namespace {

cv::Scalar color_of(int class_index) {
  const auto hue = static_cast<unsigned char>((9 + 111 * std::max(class_index, 0)) % 180);
  cv::Mat3b pixel(1, 1, cv::Vec3b(hue, 220, 255));
  cv::cvtColor(pixel, pixel, cv::COLOR_HSV2BGR);
  return {static_cast<double>(pixel(0)[0]), static_cast<double>(pixel(0)[1]),
          static_cast<double>(pixel(0)[2])};
}

void draw(cv::Mat& canvas, const Detection& detection, const std::string& name) {
  constexpr double kFontScale = 0.5;
  const auto color = color_of(detection.class_index);
  const cv::Point corner(static_cast<int>(detection.box.x_min), static_cast<int>(detection.box.y_min));
  const cv::Point opposite(static_cast<int>(detection.box.x_max), static_cast<int>(detection.box.y_max));
  cv::rectangle(canvas, corner, opposite, color, 2);
  const std::string text = cv::format("%s %.2f", name.c_str(), static_cast<double>(detection.score));
  int baseline = 0;
  const auto size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kFontScale, 1, &baseline);
  const cv::Point origin(std::clamp(corner.x, 0, std::max(0, canvas.cols - size.width)),
                         std::max(corner.y - 4, size.height + 2));
  cv::rectangle(canvas, origin + cv::Point(-1, baseline), origin + cv::Point(size.width, -size.height - 2),
                color, cv::FILLED);
  cv::putText(canvas, text, origin, cv::FONT_HERSHEY_SIMPLEX, kFontScale, cv::Scalar::all(0), 1, cv::LINE_AA);
}

/// A bgr8 copy: never draw into the original. Throws what cv_bridge throws.
cv::Mat bgr_copy(const SharedImage& image) {
  if (image.view.format == PixelFormat::kYuv422Yuy2) {  // unknown to cv_bridge
    cv::Mat bgr;
    cv::cvtColor(image.holder->image, bgr, cv::COLOR_YUV2BGR_YUY2);
    return bgr;
  }
  // cvtColor shares the pixels when the image was bgr8 already.
  return cv_bridge::cvtColor(image.holder, sensor_msgs::image_encodings::BGR8)->image.clone();
}

}  // namespace

Result<sensor_msgs::ImagePtr> annotate(const SharedImage& image, const Detections& detections,
                                       const std::vector<std::string>& class_names) {
  try {
    cv_bridge::CvImage canvas(image.holder->header, sensor_msgs::image_encodings::BGR8, bgr_copy(image));
    for (const auto& detection : detections)
      draw(canvas.image, detection, class_name(class_names, detection.class_index));
    return canvas.toImageMsg();
  } catch (const std::exception& error) {
    return fail(ErrorCode::kUnsupported, std::string("cannot draw into this image: ") + error.what());
  }
}

}  // namespace extperfc::ros_convert
