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

}  // namespace extperfc::mapping
