#pragma once

#include <optional>

#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::ros_navigate {

/// A scan and where the robot was when it was taken.
struct PlacedScan {
  LaserScan scan;
  Pose2 odom_T_base;                  ///< at its stamp
  std::optional<Pose2> map_T_odom{};  ///< the latest; empty: not known yet
  double height_m{0};  ///< of its plane above the floor; of the lidar, where the scan has heights
};

}  // namespace extperfc::ros_navigate
