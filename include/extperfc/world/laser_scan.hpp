#pragma once

#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc {

/// One sweep of a planar lidar. Ray i points at `angle_min + i * angle_increment` in the sensor's frame.
///
/// A range counts when it is finite and lies inside [range_min, range_max]. +infinity (and anything above
/// range_max) says that the ray met nothing up to range_max, as REP 117 has it; NaN, zero, negative ranges
/// and those below range_min say nothing at all, and never that the path is free.
struct LaserScan {
  double stamp_s{0};          ///< of the first ray [s]
  double angle_min{0};        ///< [rad]
  double angle_increment{0};  ///< [rad]; negative for a scanner that hangs upside down
  double range_min{0};        ///< [m]
  double range_max{0};        ///< [m]
  Pose2 base_T_sensor;        ///< where the scanner sits on the robot
  std::vector<float> ranges;  ///< [m]
  /// Of what each ray met [m] above the floor, as long as ranges: a scan that was made of a cloud. Empty: its
  /// own.
  std::vector<float> heights_m{};
};

/// Whether a range of the scan counts as that of something that the ray met.
[[nodiscard]] bool is_return(const LaserScan& scan, float range_m);

/// Rays that met something.
[[nodiscard]] std::size_t count_returns(const LaserScan& scan);

/// A round place on the floor.
struct Disc {
  Eigen::Vector2d middle_m{Eigen::Vector2d::Zero()};
  double radius_m{0};
};

/// The scan without its returns on the discs, which say nothing then (NaN). Discs are in the frame of the
/// sensor's pose. O(rays * discs).
[[nodiscard]] LaserScan without_discs(LaserScan scan, const std::vector<Disc>& discs,
                                      const Pose2& frame_T_sensor);

/// An error that names the first field that cannot be: a stamp or
/// angles that are not finite, a zero increment, a sweep of more
/// than one and a half revolutions, range_max not above range_min, no rays or more than 100,000, not as many
/// heights as rays.
[[nodiscard]] Result<void> validate(const LaserScan& scan);

}  // namespace extperfc
