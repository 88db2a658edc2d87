#pragma once

#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/footprint.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// What earlier scans showed beside the robot and the newest one does not. A scan leaves out what lies so
/// near to the robot that it could be a part of it, and a door's frame is lost in the moment in which the
/// base comes too near to it. Bounded by the area of the strip around the footprint. One thread at a time.
class NearMemory {
 public:
  /// reach_m: width of the strip around the footprint in which scans may be blind, from 0 to 0.5; 0: nothing
  /// is remembered. Throws std::invalid_argument otherwise.
  explicit NearMemory(double reach_m);

  /// Adds to the points of a scan (base's frame) those that scans before it had in the strip, unless the scan
  /// has one within 4 cm of them; 1.5 cm nearer to the base than they were seen. Forgotten for good: what is
  /// outside of the strip by now, or deeper than 5 cm inside the footprint. odom_T_base: at the scan's stamp,
  /// in a frame that does not jump. A pose that is not finite changes nothing. O(points + points in the strip
  /// squared).
  void complete(std::vector<Eigen::Vector2d>& points_m, const Footprint& footprint, const Pose2& odom_T_base);

 private:
  double reach_m_;
  std::vector<Eigen::Vector2d> kept_m_;  ///< in or beside the strip, frame of odom
};

}  // namespace extperfc::navigate
