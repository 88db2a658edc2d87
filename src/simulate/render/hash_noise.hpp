#pragma once

#include <cstdint>

/// Noise that is a function of a key and a counter, so that it does not depend on the order of calls and runs
/// in all lanes at once.
namespace extperfc::simulate {

struct NoiseKey {
  std::uint32_t a{0};
  std::uint32_t b{0};
};

/// Key of one stream of noise. `stream` separates what one sensor draws at one time.
[[nodiscard]] NoiseKey noise_key(std::uint64_t seed, std::uint32_t sensor, double time_s,
                                 std::uint32_t stream);

/// 32 bits that look random.
[[nodiscard]] inline std::uint32_t noise_bits(NoiseKey key, std::uint32_t counter) {
  std::uint32_t x = counter * 0x9E3779B1U + key.a;
  x ^= x >> 16;
  x *= 0x85EBCA77U;
  x ^= (x >> 13) ^ key.b;
  x *= 0xC2B2AE3DU;
  return x ^ (x >> 16);
}

/// Uniform in [0, 1), 24 bits.
[[nodiscard]] inline float uniform(std::uint32_t bits) {
  return static_cast<float>(static_cast<std::int32_t>(bits >> 8)) * (1.0F / 16777216.0F);
}

/// Near-normal with mean 0 and standard deviation 1, within +-3.45: the sum of the four bytes (a byte's
/// variance is (256^2 - 1) / 12).
[[nodiscard]] inline float gauss(std::uint32_t bits) {
  const std::uint32_t pairs = (bits & 0x00FF00FFU) + ((bits >> 8) & 0x00FF00FFU);
  const std::uint32_t sum = (pairs & 0xFFFFU) + (pairs >> 16);
  return (static_cast<float>(static_cast<std::int32_t>(sum)) - 510.0F) * 0.0067659F;
}

}  // namespace extperfc::simulate
