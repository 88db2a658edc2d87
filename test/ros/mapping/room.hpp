#pragma once

#include <vector>

#include <sensor_msgs/LaserScan.h>

#include "extperfc/world/pose.hpp"

namespace extperfc::ros_test {

/// What a planar lidar sees in a room of 9 x 7 m with two boxes and a wing wall, so that no two places look
/// alike:
///
///     y = 4  +-----------------------------+
///            |              +--+           |
///            |------        +--+           |
///     y = 0  |         o  (0, 0)           |
///            |   +--+                      |
///     y = -3 +---+--+----------------------+
///            x = -4                        x = 5
struct Lidar {
  int rays{360};
  double angle_min{-M_PI};
  double angle_increment{M_PI / 180};
  double range_max{20.0};
  double noise_m{0.01};  ///< standard deviation
};

/// Ranges from a pose in the room; the noise depends on `seed` alone.
[[nodiscard]] std::vector<float> look(const Pose2& room_T_lidar, const Lidar& lidar, unsigned seed = 1);

/// As a driver sends them, in the frame "laser".
[[nodiscard]] sensor_msgs::LaserScanPtr scan_message(const Pose2& room_T_lidar, const ros::Time& stamp,
                                                     const Lidar& lidar = {}, unsigned seed = 1);

/// Distance of a point to the nearest wall [m].
[[nodiscard]] double distance_to_wall(double x_m, double y_m);

}  // namespace extperfc::ros_test
