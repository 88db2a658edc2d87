#include "extperfc/world/image_view.hpp"

#include <array>

namespace extperfc {

namespace {

struct FormatInfo {
  PixelFormat format;
  std::string_view encoding;
  std::size_t bytes;
};

constexpr std::array<FormatInfo, 14> kFormats{{
    {PixelFormat::kRgb8, "rgb8", 3},
    {PixelFormat::kBgr8, "bgr8", 3},
    {PixelFormat::kRgba8, "rgba8", 4},
    {PixelFormat::kBgra8, "bgra8", 4},
    {PixelFormat::kMono8, "mono8", 1},
    {PixelFormat::kMono16, "mono16", 2},
    {PixelFormat::kBayerRggb8, "bayer_rggb8", 1},
    {PixelFormat::kBayerBggr8, "bayer_bggr8", 1},
    {PixelFormat::kBayerGbrg8, "bayer_gbrg8", 1},
    {PixelFormat::kBayerGrbg8, "bayer_grbg8", 1},
    {PixelFormat::kYuv422, "yuv422", 2},
    {PixelFormat::kYuv422Yuy2, "yuv422_yuy2", 2},
    {PixelFormat::kDepth16Mm, "16UC1", 2},
    {PixelFormat::kDepth32M, "32FC1", 4},
}};

const FormatInfo& info(PixelFormat format) {
  return kFormats.at(static_cast<std::size_t>(format));
}

}  // namespace

std::size_t bytes_per_pixel(PixelFormat format) {
  return info(format).bytes;
}

std::optional<PixelFormat> pixel_format_from_encoding(std::string_view encoding) {
  if (encoding == "8UC3") return PixelFormat::kBgr8;  // what OpenCV users mean by a plain 3-channel image
  if (encoding == "8UC1") return PixelFormat::kMono8;
  for (const auto& entry : kFormats)
    if (entry.encoding == encoding) return entry.format;
  return std::nullopt;
}

std::string_view encoding_of(PixelFormat format) {
  return info(format).encoding;
}

bool is_depth(PixelFormat format) {
  return format == PixelFormat::kDepth16Mm || format == PixelFormat::kDepth32M;
}

}  // namespace extperfc
