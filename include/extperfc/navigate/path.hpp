#pragma once

#include <vector>

#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// Poses of the base from start to goal, at most 0.1 m and 0.2 rad apart; the yaw is the heading to drive
/// with, which for a holonomic base need not be the direction of motion.
struct Path {
  std::vector<Pose2> poses;
  double cost{0};  ///< of the planner: length [m] weighed by cell costs
};

[[nodiscard]] double length_m(const Path& path);

}  // namespace extperfc::navigate
