#pragma once

#include <cmath>
#include <optional>

#include "extperfc/base/rng.hpp"

#include "arm/kinematics/task.hpp"

namespace extperfc::arm::ik {

template <int N>
[[nodiscard]] Bounds<N> bounds_of(const ArmChain& chain) {
  return {Joints<N>(chain.limits().lower), Joints<N>(chain.limits().upper)};
}

/// Random positions, uniform in the bounds; joints without end within half a turn of 0.
template <int N>
class Draws {
 public:
  Draws(const Bounds<N>& bounds, std::uint64_t seed) : bounds_(bounds), seed_(seed) {}

  [[nodiscard]] Joints<N> next() {
    if (!rng_) rng_.emplace(seed_);  // late: seeding costs as much as an easy solution
    Joints<N> q = bounds_.lower;
    for (int i = 0; i < q.size(); ++i) {
      const bool endless = std::isinf(bounds_.lower[i]);
      q[i] =
          endless ? rng_->uniform(-kTurn / 2, kTurn / 2) : rng_->uniform(bounds_.lower[i], bounds_.upper[i]);
    }
    return q;
  }

 private:
  const Bounds<N>& bounds_;
  std::uint64_t seed_;
  std::optional<Rng> rng_;
};

/// Joints without end moved by whole turns to within half a turn of `seed`.
template <int N>
void unwind(const Bounds<N>& bounds, const Joints<N>& seed, Joints<N>& q) {
  for (int i = 0; i < q.size(); ++i)
    if (std::isinf(bounds.lower[i])) q[i] = seed[i] + std::remainder(q[i] - seed[i], kTurn);
}

}  // namespace extperfc::arm::ik
