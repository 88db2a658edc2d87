#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "extperfc/arm/motion_pipeline.hpp"

namespace extperfc::arm {

struct Attempt {
  MotionOutcome outcome;
  bool unproven{false};  ///< there is a path, but no trajectory along it that is proven free
};

/// Plans; where the trajectory cannot be proven free, plans once more with another seed if time is left. When
/// the second attempt finds no path, the first outcome counts.
inline MotionOutcome plan_up_to_twice(std::uint64_t seed,
                                      const std::function<Attempt(std::uint64_t)>& attempt,
                                      const std::function<bool()>& time_left) {
  constexpr std::uint64_t kOtherSeed = 1000;  // a team plans with the next few too
  auto first = attempt(seed);
  if (!first.unproven || !time_left()) return std::move(first.outcome);
  auto second = attempt(seed + kOtherSeed);
  return std::move((second.outcome.code == ArmCode::kPlanningTimeout ? first : second).outcome);
}

}  // namespace extperfc::arm
