#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace extperfc {

/// Pixel layouts that cameras deliver. Names are those of sensor_msgs/image_encodings.
enum class PixelFormat {
  kRgb8,
  kBgr8,
  kRgba8,
  kBgra8,
  kMono8,
  kMono16,  ///< 16-bit grey, little endian
  kBayerRggb8,
  kBayerBggr8,
  kBayerGbrg8,
  kBayerGrbg8,
  kYuv422,      ///< U Y V Y, ROS "yuv422"
  kYuv422Yuy2,  ///< Y U Y V, ROS "yuv422_yuy2"
  kDepth16Mm,   ///< 16UC1, millimetres, 0 = no measurement
  kDepth32M,    ///< 32FC1, metres, NaN, infinite or <= 0 = no measurement
};

/// Bytes of one pixel.
[[nodiscard]] std::size_t bytes_per_pixel(PixelFormat format);

/// The format of a ROS encoding string such as "rgb8" or "16UC1"; empty when it is unknown.
[[nodiscard]] std::optional<PixelFormat> pixel_format_from_encoding(std::string_view encoding);

/// The ROS encoding string of a format.
[[nodiscard]] std::string_view encoding_of(PixelFormat format);

[[nodiscard]] bool is_depth(PixelFormat format);

/// A view of an image that it does not own: row-major, top row first. Copying the view copies no pixels.
struct ImageView {
  const std::uint8_t* data{nullptr};
  int width{0};              ///< pixels
  int height{0};             ///< pixels
  std::size_t row_bytes{0};  ///< distance between the starts of two rows; at least width * bytes_per_pixel
  PixelFormat format{PixelFormat::kBgr8};

  [[nodiscard]] bool empty() const { return data == nullptr || width <= 0 || height <= 0; }
  [[nodiscard]] const std::uint8_t* row(int y) const {
    return data + static_cast<std::size_t>(y) * row_bytes;
  }
};

}  // namespace extperfc
