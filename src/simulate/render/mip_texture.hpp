#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace extperfc::simulate {

/// sRGB, [0, 1].
struct Colour {
  float r, g, b;
};

[[nodiscard]] inline Colour grey(float value) {
  return {value, value, value};
}
/// `a` at t = 0, `b` at t = 1.
[[nodiscard]] inline Colour mix(const Colour& a, const Colour& b, float t) {
  return {a.r + (b.r - a.r) * t, a.g + (b.g - a.g) * t, a.b + (b.b - a.b) * t};
}
[[nodiscard]] inline Colour scaled(const Colour& c, float by) {
  return {c.r * by, c.g * by, c.b * by};
}

/// A square pattern that repeats, with all its halvings down to one pixel: 1.4 MB. Pixels are 0x00BBGGRR,
/// sRGB.
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

/// Draws a pattern: `colour_at` is asked once for the middle of each pixel of level 0, x to the right and y
/// down, both in (0, 1). Colours outside [0, 1] are clamped.
[[nodiscard]] MipTexture make_mip_texture(const std::function<Colour(float x, float y)>& colour_at);

}  // namespace extperfc::simulate
