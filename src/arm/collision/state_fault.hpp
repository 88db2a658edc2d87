#pragma once

#include <optional>
#include <string>

#include "extperfc/arm/collision_checker.hpp"

namespace extperfc::arm {

/// Why a state cannot be the start or the goal of a motion.
struct StateFault {
  std::string message;             ///< one line, e.g. "start in collision: table touches left_hand"
  int joint{-1};                   ///< the one farthest outside its limits
  std::optional<Contact> contact;  ///< what it touches, or what is too near to be proven free
};

/// "first touches second".
[[nodiscard]] std::string text_of(const Contact& contact);

/// Nothing when every joint is within its limits, or outside by `slack_rad` at most. `what`: "start" or
/// "goal".
[[nodiscard]] std::optional<StateFault> outside_limits(const CollisionModel& model, const JointLimits& limits,
                                                       const JointVector& state, double slack_rad,
                                                       const std::string& what);

/// Of a finite state that is not free.
[[nodiscard]] StateFault in_collision(CollisionChecker& checker, const JointVector& state,
                                      const std::string& what);

}  // namespace extperfc::arm
