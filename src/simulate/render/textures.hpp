#pragma once

#include <cstdint>
#include <vector>

#include "extperfc/world/shape.hpp"

namespace extperfc::simulate {

/// A square pattern that repeats, with all its halvings down to one pixel. Pixels are 0x00BBGGRR, sRGB.
struct MipTexture {
  static constexpr int kLevels = 10;
  static constexpr int kSize = 1 << (kLevels - 1);  ///< pixels of level 0 along a side

  /// Level i has kSize >> i pixels along a side and starts at first_pixel(size).
  std::vector<std::uint32_t> pixels;
  float brightness{1};  ///< mean linear luminance, (0, 1]

  /// Sum of the sizes of the larger levels: a geometric series.
  [[nodiscard]] static constexpr int first_pixel(int size) {
    return (4 * kSize * kSize - 4 * size * size) / 3;
  }
};

/// Null for Texture::kNone. Made at the first call (some milliseconds) and kept; any thread. The same on
/// every machine but for rounding.
[[nodiscard]] const MipTexture* texture_of(Texture texture);

}  // namespace extperfc::simulate
