#pragma once

#include <cmath>
#include <cstdint>
#include <utility>

namespace extperfc::ros_simulate {

/// Reports when an event that happens `rate_hz` times per second of simulated time is due. The times are the
/// multiples of the period, independent of the length of a step: at 240 steps per second 100 Hz comes after
/// two or three steps in turn.
class Ticker {
 public:
  /// Never due when the rate is 0.
  explicit Ticker(double rate_hz) : rate_hz_(rate_hz) {}

  /// True when a multiple of the period (not 0) was reached since the last call; several count once. Time
  /// that goes back starts anew.
  [[nodiscard]] bool due(double time_s) {
    const auto tick = static_cast<std::int64_t>(std::floor(time_s * rate_hz_ + kRounding));
    if (tick < last_) last_ = 0;
    return std::exchange(last_, tick) < tick;
  }

  [[nodiscard]] double rate_hz() const { return rate_hz_; }

 private:
  static constexpr double kRounding = 1e-6;  ///< of a period: sums of steps miss a multiple by less
  double rate_hz_;
  std::int64_t last_{0};
};

}  // namespace extperfc::ros_simulate
