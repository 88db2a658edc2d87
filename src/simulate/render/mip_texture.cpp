#include "simulate/render/mip_texture.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace extperfc::simulate {

namespace {

Colour clamped(const Colour& c) {
  return {std::clamp(c.r, 0.0F, 1.0F), std::clamp(c.g, 0.0F, 1.0F), std::clamp(c.b, 0.0F, 1.0F)};
}

std::uint32_t pack(const Colour& c) {
  const auto byte = [](float v) { return static_cast<std::uint32_t>(std::lround(v * 255.0F)); };
  return byte(c.r) | byte(c.g) << 8 | byte(c.b) << 16;
}

/// The level of half the size: each pixel is the mean of 2 x 2. Levels stay unrounded, or the
/// rounding of eight of them would add up to two grey values.
std::vector<Colour> halved(const std::vector<Colour>& larger, int size) {
  std::vector<Colour> smaller;
  smaller.reserve(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const Colour* const upper = larger.data() + static_cast<std::ptrdiff_t>(2 * y) * (2 * size) + 2 * x;
      const Colour* const lower = upper + 2 * size;
      smaller.push_back({0.25F * (upper[0].r + upper[1].r + lower[0].r + lower[1].r),
                         0.25F * (upper[0].g + upper[1].g + lower[0].g + lower[1].g),
                         0.25F * (upper[0].b + upper[1].b + lower[0].b + lower[1].b)});
    }
  return smaller;
}

std::vector<Colour> level_zero(const std::function<Colour(float, float)>& colour_at) {
  constexpr int n = MipTexture::kSize;
  std::vector<Colour> level;
  level.reserve(static_cast<std::size_t>(n) * n);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x)
      level.push_back(
          clamped(colour_at((static_cast<float>(x) + 0.5F) / n, (static_cast<float>(y) + 0.5F) / n)));
  return level;
}

/// Linear luminance of the one pixel of the last level.
float mean_luminance(const MipTexture& texture) {
  const auto linear = [&](int shift) {
    const float value = static_cast<float>(texture.pixels.back() >> shift & 0xFFU) / 255.0F;
    return value * value;
  };
  return 0.2126F * linear(0) + 0.7152F * linear(8) + 0.0722F * linear(16);
}

}  // namespace

MipTexture make_mip_texture(const std::function<Colour(float x, float y)>& colour_at) {
  MipTexture texture;
  texture.pixels.reserve(static_cast<std::size_t>(MipTexture::first_pixel(1)) + 1);
  std::vector<Colour> level = level_zero(colour_at);
  for (int size = MipTexture::kSize; size > 0; size /= 2) {
    if (size < MipTexture::kSize) level = halved(level, size);
    std::transform(level.begin(), level.end(), std::back_inserter(texture.pixels), pack);
  }
  texture.brightness = mean_luminance(texture);
  return texture;
}

}  // namespace extperfc::simulate
