#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace extperfc::ros_simulate {

/// Deadlines of the simulation's steps on the steady clock.
class Pacer {
 public:
  using Clock = std::chrono::steady_clock;
  using Time = Clock::time_point;
  /// A simulation that is behind by more starts anew from now instead of racing after it.
  static constexpr std::chrono::milliseconds kLongestDebt{100};

  /// `factor`: simulated seconds per second; 0: as fast as possible.
  explicit Pacer(double factor) : factor_(factor) {}

  void set_factor(double factor, Time now) {
    factor_ = factor;
    due_ = now;
  }
  [[nodiscard]] double factor() const { return factor_; }

  /// The next step may run at once: at the start and after a pause.
  void restart(Time now) { due_ = now; }

  /// When the next step may run; not later than `now` when it is late already.
  [[nodiscard]] Time due(Time now) {
    if (factor_ <= 0) return now;
    if (now - due_ > kLongestDebt) {
      due_ = now;
      ++debts_dropped_;
    }
    return due_;
  }

  /// A step of `step_s` simulated seconds was made.
  void advance(double step_s) {
    if (factor_ > 0)
      due_ += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(step_s / factor_));
  }

  /// How often the simulation gave up what it was behind.
  [[nodiscard]] std::uint64_t debts_dropped() const { return debts_dropped_; }

 private:
  double factor_;
  Time due_{};
  std::uint64_t debts_dropped_{0};
};

/// Measures simulated seconds per second, over stretches of at least a second.
class FactorMeter {
 public:
  using Time = Pacer::Time;

  void restart(Time now) {
    begin_ = now;
    simulated_s_ = 0;
  }

  /// The factor of the stretch that ends with this step, when one ends.
  [[nodiscard]] std::optional<double> stepped(double step_s, Time now) {
    simulated_s_ += step_s;
    const double passed_s = std::chrono::duration<double>(now - begin_).count();
    if (passed_s < 1.0) return std::nullopt;
    const double factor = simulated_s_ / passed_s;
    restart(now);
    return factor;
  }

 private:
  Time begin_{};
  double simulated_s_{0};
};

}  // namespace extperfc::ros_simulate
