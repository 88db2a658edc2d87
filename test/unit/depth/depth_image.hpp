#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "extperfc/world/image_view.hpp"

namespace extperfc::depth {

/// A depth image for tests, in either format, with optional padding after each row and an odd start
/// address.
class DepthImage {
 public:
  DepthImage(int width, int height, PixelFormat format = PixelFormat::kDepth16Mm, std::size_t padding = 0,
             std::size_t offset = 0)
      : width_(width),
        height_(height),
        format_(format),
        row_bytes_(static_cast<std::size_t>(width) * bytes_per_pixel(format) + padding),
        offset_(offset),
        bytes_(offset + row_bytes_ * static_cast<std::size_t>(height), 0xAB) {
    fill([](int, int) { return 0.0; });
  }

  /// Sets one pixel [m].
  void set(int x, int y, double depth_m) {
    std::uint8_t* const place = bytes_.data() + offset_ + static_cast<std::size_t>(y) * row_bytes_ +
                                static_cast<std::size_t>(x) * bytes_per_pixel(format_);
    if (format_ == PixelFormat::kDepth16Mm) {
      const auto mm = static_cast<std::uint16_t>(std::lround(1000.0 * depth_m));
      std::memcpy(place, &mm, sizeof mm);
    } else {
      const auto m = static_cast<float>(depth_m);
      std::memcpy(place, &m, sizeof m);
    }
  }

  /// Sets every pixel to depth(x, y) [m].
  template <typename Depth>
  DepthImage& fill(Depth depth) {
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) set(x, y, depth(x, y));
    return *this;
  }

  [[nodiscard]] ImageView view() const {
    return {bytes_.data() + offset_, width_, height_, row_bytes_, format_};
  }

 private:
  int width_;
  int height_;
  PixelFormat format_;
  std::size_t row_bytes_;
  std::size_t offset_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace extperfc::depth
