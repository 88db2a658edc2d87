#pragma once

#include <cmath>
#include <cstdint>

#include "arm/kinematics/task.hpp"

namespace extperfc::arm {

template <int N>
[[nodiscard]] Bounds<N> bounds_of(const ArmChain& chain) {
  return {Joints<N>(chain.limits().lower), Joints<N>(chain.limits().upper)};
}

/// The step along the first axis of the sequence below: 1/g with g^(n+1) = g + 1, g > 1; n from 1 to
/// kMaxJoints.
[[nodiscard]] double spread_step(int n);

/// Positions that fill the bounds evenly; joints without end within half a revolution of 0. The additive
/// recurrence of Roberts ("The unreasonable effectiveness of quasirandom sequences", 2018): its axes step by
/// the powers of 1/g. With 100,000 poses of a seven-joint arm a third as many need more than 100 restarts
/// from it as from independent draws.
template <int N>
class Draws {
 public:
  Draws(const Bounds<N>& bounds, std::uint64_t seed) : bounds_(bounds), seed_(seed) {}

  [[nodiscard]] Joints<N> next() {
    if (!begun_) begin();  // late: many searches draw nothing
    Joints<N> q = bounds_.lower;
    for (int i = 0; i < q.size(); ++i) {
      fraction_[i] += step_[i];
      if (fraction_[i] >= 1) fraction_[i] -= 1;
      const bool endless = std::isinf(bounds_.lower[i]);
      const double low = endless ? -kRevolution / 2 : bounds_.lower[i];
      q[i] = low + fraction_[i] * ((endless ? kRevolution / 2 : bounds_.upper[i]) - low);
    }
    return q;
  }

 private:
  /// Seeds begin at other places of the same sequence.
  void begin() {
    constexpr std::uint64_t kSeeds = 1'000'003;
    constexpr double kApart = 7919;
    const auto place = kApart * static_cast<double>(seed_ % kSeeds);
    fraction_ = step_ = bounds_.lower;
    const double first = spread_step(static_cast<int>(fraction_.size()));
    double step = 1;
    for (int i = 0; i < fraction_.size(); ++i) {
      step *= first;
      step_[i] = step;
      const double fraction = 0.5 + place * step;
      fraction_[i] = fraction - std::floor(fraction);
    }
    begun_ = true;
  }

  const Bounds<N>& bounds_;
  std::uint64_t seed_;
  bool begun_{false};
  Joints<N> fraction_, step_;
};

/// Joints without end moved by whole revolutions to within half a revolution of `seed`.
template <int N>
void unwind(const Bounds<N>& bounds, const Joints<N>& seed, Joints<N>& q) {
  for (int i = 0; i < q.size(); ++i)
    if (std::isinf(bounds.lower[i])) q[i] = seed[i] + std::remainder(q[i] - seed[i], kRevolution);
}

}  // namespace extperfc::arm
