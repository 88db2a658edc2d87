#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::ros_navigate {

/// A scan and where the robot was when it was taken.
struct PlacedScan {
  LaserScan scan;
  Pose2 odom_T_base;                  ///< at its stamp
  std::optional<Pose2> map_T_odom{};  ///< the latest; empty: not known yet
  double height_m{0};                 ///< of its plane above the floor
};

/// End points of the rays that met something, in the base's frame [m].
[[nodiscard]] std::vector<Eigen::Vector2d> points_of(const LaserScan& scan);

}  // namespace extperfc::ros_navigate
