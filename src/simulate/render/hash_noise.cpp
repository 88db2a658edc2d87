#include "simulate/render/hash_noise.hpp"

#include <cmath>

namespace extperfc::simulate {

namespace {

/// One step of a 64-bit avalanche.
std::uint64_t scramble(std::uint64_t x) {
  x ^= x >> 32;
  x *= 0xD6E8FEB86659FD93ULL;
  x ^= x >> 29;
  x *= 0x9E3779B97F4A7C15ULL;
  return x ^ (x >> 32);
}

}  // namespace

NoiseKey noise_key(std::uint64_t seed, std::uint32_t sensor, double time_s, std::uint32_t stream) {
  const auto nanoseconds = static_cast<std::uint64_t>(std::llround(time_s * 1e9));
  std::uint64_t x = scramble(seed + 0x9E3779B97F4A7C15ULL);
  x = scramble(x ^ (static_cast<std::uint64_t>(sensor) << 32 | stream));
  x = scramble(x + nanoseconds);
  return {static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(x >> 32)};
}

}  // namespace extperfc::simulate
