#pragma once

#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/MultiEchoLaserScan.h>

#include "extperfc/base/error.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::ros_convert {

/// A planar scan from a message and from where the scanner sits on the robot. A scanner that is mounted
/// upside down (its z axis points to the floor) gets angles that run backwards. Errors: a scanner tilted by
/// more than `max_tilt_rad` against the base's floor plane, and what validate(LaserScan) refuses.
[[nodiscard]] Result<LaserScan> to_laser_scan(const sensor_msgs::LaserScan& message,
                                              const Pose& base_T_scanner, double max_tilt_rad = 0.1);

/// The strongest echo of every ray: a planar scan as above. Without intensities the first echo counts. Echoes
/// outside [range_min, range_max] count only when there is no other; a ray without echoes becomes NaN,
/// because drivers leave out what they could not measure and what met nothing alike.
[[nodiscard]] sensor_msgs::LaserScan to_single_echo(const sensor_msgs::MultiEchoLaserScan& message);

}  // namespace extperfc::ros_convert
