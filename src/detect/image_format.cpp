#include "detect/image_format.hpp"

#include <string>

#include <opencv2/imgproc.hpp>

namespace extperfc::detect {

namespace {

constexpr std::array<int, 3> kRgb{0, 1, 2};
constexpr std::array<int, 3> kBgr{2, 1, 0};
constexpr std::array<int, 3> kGreyOrder{0, 0, 0};

/// Code of the conversion to BGR of what needs none to be resized; kDirect: it is BGR.
int to_bgr(PixelFormat format) {
  switch (format) {
    case PixelFormat::kRgb8:
      return cv::COLOR_RGB2BGR;
    case PixelFormat::kRgba8:
      return cv::COLOR_RGBA2BGR;
    case PixelFormat::kBgra8:
      return cv::COLOR_BGRA2BGR;
    case PixelFormat::kMono8:
    case PixelFormat::kMono16:
      return cv::COLOR_GRAY2BGR;
    default:
      return kDirect;
  }
}

}  // namespace

// OpenCV names a Bayer pattern after the second row's second and third pixel, ROS after the first 2 x 2
// pixels.
FormatTraits traits_of(PixelFormat format) {
  switch (format) {
    case PixelFormat::kRgb8:
      return {CV_8UC3, kDirect, kRgb};
    case PixelFormat::kBgr8:
      return {CV_8UC3, kDirect, kBgr};
    case PixelFormat::kRgba8:
      return {CV_8UC4, kDirect, kRgb};
    case PixelFormat::kBgra8:
      return {CV_8UC4, kDirect, kBgr};
    case PixelFormat::kMono8:
      return {CV_8UC1, kDirect, kGreyOrder};
    case PixelFormat::kMono16:
      return {CV_16UC1, kDirect, kGreyOrder};
    case PixelFormat::kBayerRggb8:
      return {CV_8UC1, cv::COLOR_BayerBG2BGR, kBgr};
    case PixelFormat::kBayerBggr8:
      return {CV_8UC1, cv::COLOR_BayerRG2BGR, kBgr};
    case PixelFormat::kBayerGbrg8:
      return {CV_8UC1, cv::COLOR_BayerGR2BGR, kBgr};
    case PixelFormat::kBayerGrbg8:
      return {CV_8UC1, cv::COLOR_BayerGB2BGR, kBgr};
    case PixelFormat::kYuv422:
      return {CV_8UC2, cv::COLOR_YUV2BGR_UYVY, kBgr};
    case PixelFormat::kYuv422Yuy2:
      return {CV_8UC2, cv::COLOR_YUV2BGR_YUY2, kBgr};
    case PixelFormat::kDepth16Mm:
    case PixelFormat::kDepth32M:
      break;
  }
  return {CV_8UC1, kDirect, kGreyOrder};
}

Result<void> check_image(const ImageView& image) {
  const std::string size = std::to_string(image.width) + " x " + std::to_string(image.height);
  const std::string encoding(encoding_of(image.format));
  if (image.empty()) return fail(ErrorCode::kInvalidArgument, "the image is empty (" + size + " pixels)");
  if (is_depth(image.format))
    return fail(ErrorCode::kUnsupported,
                "a depth image (" + encoding + ") cannot be searched for objects: give a colour image");
  const auto min_row_bytes = static_cast<std::size_t>(image.width) * bytes_per_pixel(image.format);
  if (image.row_bytes < min_row_bytes)
    return fail(ErrorCode::kInvalidArgument, "a row of the " + size + " " + encoding + " image needs " +
                                                 std::to_string(min_row_bytes) + " bytes, but its step is " +
                                                 std::to_string(image.row_bytes));
  return {};
}

cv::Mat mat_around(const ImageView& image, const FormatTraits& traits) {
  // cv::Mat has no read-only form.
  return {image.height, image.width, traits.type, const_cast<std::uint8_t*>(image.data), image.row_bytes};
}

Result<cv::Mat> bgr_image(const ImageView& image) try {
  if (const auto checked = check_image(image); !checked) return tl::unexpected(checked.error());
  const FormatTraits traits = traits_of(image.format);
  cv::Mat pixels = mat_around(image, traits);
  if (image.format == PixelFormat::kMono16) pixels.convertTo(pixels, CV_8U, kMono16ToByte);
  const int conversion = traits.conversion == kDirect ? to_bgr(image.format) : traits.conversion;
  if (conversion == kDirect) return pixels;
  cv::Mat bgr;
  cv::cvtColor(pixels, bgr, conversion);
  return bgr;
} catch (const cv::Exception& error) {
  return fail(ErrorCode::kInvalidArgument, "cannot convert an image to bgr8: " + error.err);
}

}  // namespace extperfc::detect
