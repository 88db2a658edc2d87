#pragma once

#include <cstdint>
#include <random>

namespace extperfc {

/// The one source of randomness: always seeded by the caller, the same sequence on every run of one build.
class Rng {
 public:
  explicit Rng(std::uint64_t seed) : engine_(seed) {}

  /// Uniform in [low, high).
  [[nodiscard]] double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  /// Normal with the given mean and standard deviation.
  [[nodiscard]] double normal(double mean, double sigma) {
    return std::normal_distribution<double>(mean, sigma)(engine_);
  }
  /// True with the given probability in [0, 1].
  [[nodiscard]] bool chance(double probability) { return uniform(0.0, 1.0) < probability; }
  /// Uniform integer in [low, high], both included.
  [[nodiscard]] int integer(int low, int high) {
    return std::uniform_int_distribution<int>(low, high)(engine_);
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace extperfc
