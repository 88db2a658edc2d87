#pragma once

#include <array>

#include <opencv2/core.hpp>

#include "extperfc/base/error.hpp"
#include "extperfc/world/image_view.hpp"

namespace extperfc::detect {

inline constexpr double kMono16ToByte = 1.0 / 257;  // 65535 -> 255
inline constexpr int kDirect = -1;

/// How OpenCV sees an image format.
struct FormatTraits {
  int type;                     ///< of the cv::Mat around the image
  int conversion;               ///< code that makes it BGR, kDirect when it can be resized as it is
  std::array<int, 3> channels;  ///< where red, green and blue are after the conversion
};

[[nodiscard]] FormatTraits traits_of(PixelFormat format);

/// Errors: kInvalidArgument for an empty image and for rows that are too short, kUnsupported for a depth
/// image.
[[nodiscard]] Result<void> check_image(const ImageView& image);

/// The image's own memory, not to be written to.
[[nodiscard]] cv::Mat mat_around(const ImageView& image, const FormatTraits& traits);

/// The whole image as 8-bit BGR, for what cannot be computed on a small one. Shares memory with a bgr8 image,
/// so write to a copy only. Errors: those of check_image().
[[nodiscard]] Result<cv::Mat> bgr_image(const ImageView& image);

}  // namespace extperfc::detect
