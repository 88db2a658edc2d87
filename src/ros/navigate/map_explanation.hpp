#pragma once

#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::ros_navigate {

/// What of a scan the map explains. Returns near an obstacle of the map are that obstacle, seen with noise
/// and a pose that is a little wrong; marked in the cost map they would make its doors narrower.
class MapExplanation {
 public:
  void set_map(const OccupancyGrid& map, double margin_m);
  /// The scan with NaN for the returns that the map explains. O(rays).
  [[nodiscard]] LaserScan unexplained(const LaserScan& scan, const Pose2& map_T_sensor) const;

 private:
  OccupancyGrid near_;  ///< kOccupied within the margin of an obstacle
};

}  // namespace extperfc::ros_navigate
