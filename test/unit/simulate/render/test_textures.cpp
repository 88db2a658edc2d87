// Patterns and the noise behind them.

#include <array>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "simulate/render/hash_noise.hpp"
#include "simulate/render/textures.hpp"

namespace extperfc::simulate {
namespace {

constexpr std::array<Texture, 16> kAll{
    Texture::kWood,   Texture::kTiles,  Texture::kPlaster,  Texture::kCloth,
    Texture::kCarpet, Texture::kMarble, Texture::kChecker,  Texture::kStripes,
    Texture::kDots,   Texture::kPrint,  Texture::kPoster,   Texture::kBlotches,
    Texture::kBall,   Texture::kPips,   Texture::kGradient, Texture::kBooks};

double mean_green(const MipTexture& texture, int size) {
  double sum = 0;
  for (int i = 0; i < size * size; ++i)
    sum += texture.pixels[static_cast<std::size_t>(MipTexture::first_pixel(size) + i)] >> 8 & 0xFFU;
  return sum / (size * size);
}

TEST(Textures, NoneIsNone) {
  EXPECT_EQ(texture_of(Texture::kNone), nullptr);
}

TEST(Textures, EveryLevelHasTheMeanOfTheFirst) {
  for (const auto kind : kAll) {
    const MipTexture* texture = texture_of(kind);
    ASSERT_NE(texture, nullptr);
    ASSERT_EQ(texture->pixels.size(), static_cast<std::size_t>(MipTexture::first_pixel(1)) + 1);
    for (int size = MipTexture::kSize / 2; size > 0; size /= 2)
      EXPECT_NEAR(mean_green(*texture, size), mean_green(*texture, MipTexture::kSize), 1.5)
          << to_string(kind);
    EXPECT_GT(texture->brightness, 0.02F) << to_string(kind);
    EXPECT_LE(texture->brightness, 1.0F) << to_string(kind);
  }
}

TEST(Textures, EveryKindHasAPattern) {
  for (const auto kind : kAll) {
    const MipTexture* texture = texture_of(kind);
    std::uint32_t low = 255;
    std::uint32_t high = 0;
    for (int i = 0; i < MipTexture::kSize * MipTexture::kSize; ++i) {
      const std::uint32_t green = texture->pixels[static_cast<std::size_t>(i)] >> 8 & 0xFFU;
      low = std::min(low, green);
      high = std::max(high, green);
    }
    EXPECT_GE(high - low, 8U) << to_string(kind);
  }
}

TEST(HashNoise, GaussHasMeanZeroAndSigmaOne) {
  const NoiseKey key = noise_key(1, 2, 3.5, 4);
  constexpr int kCount = 200'000;
  double sum = 0;
  double sum2 = 0;
  double neighbours = 0;
  float before = 0;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const float g = gauss(noise_bits(key, i));
    sum += g;
    sum2 += g * g;
    neighbours += g * before;
    before = g;
  }
  const double standard_error = 1 / std::sqrt(kCount);
  EXPECT_NEAR(sum / kCount, 0, 5 * standard_error);
  EXPECT_NEAR(sum2 / kCount, 1, 5 * std::sqrt(2.0) * standard_error);
  EXPECT_NEAR(neighbours / kCount, 0, 5 * standard_error);
}

TEST(HashNoise, UniformFillsItsRange) {
  const NoiseKey key = noise_key(5, 0, 0, 0);
  std::array<int, 16> bins{};
  for (std::uint32_t i = 0; i < 160'000; ++i)
    ++bins[static_cast<std::size_t>(16 * uniform(noise_bits(key, i)))];
  for (const int bin : bins) EXPECT_NEAR(bin, 10'000, 5 * std::sqrt(10'000));
}

TEST(HashNoise, KeysDifferByEveryPart) {
  const NoiseKey base = noise_key(1, 2, 3, 4);
  for (const auto& other :
       {noise_key(2, 2, 3, 4), noise_key(1, 3, 3, 4), noise_key(1, 2, 3.001, 4), noise_key(1, 2, 3, 5)})
    EXPECT_TRUE(other.a != base.a && other.b != base.b);
}

}  // namespace
}  // namespace extperfc::simulate
