#pragma once

#include <cmath>

#include "extperfc/world/pose.hpp"

namespace extperfc::mapping {

/// Of the positions [m].
[[nodiscard]] inline double distance(const Pose2& a, const Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

/// [rad], [0, pi]
[[nodiscard]] inline double yaw_between(const Pose2& a, const Pose2& b) {
  return std::abs(wrap_angle(a.yaw - b.yaw));
}

/// A pose that moved by no more than this is taken as it was: the noise of a match is as large.
[[nodiscard]] inline bool stands_still(const Pose2& now, const Pose2& then) {
  constexpr double kStillM = 0.01;
  constexpr double kStillRad = 0.002;
  return distance(now, then) <= kStillM && yaw_between(now, then) <= kStillRad;
}

}  // namespace extperfc::mapping
