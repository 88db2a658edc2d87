#pragma once

#include <Eigen/Core>

#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// Which returns of a scanner the static map explains: those within a margin of one of its obstacles, along
/// each of its axes. Localization and cells are a little wrong, the farther away the more, so such a return
/// is no news.
class MapExplanation {
 public:
  /// Until then nothing is explained. `margin_m` is that of a return at the sensor; two degrees of its range
  /// are added. O(cells).
  void set_map(const OccupancyGrid& map, double margin_m);
  [[nodiscard]] bool explains(const Eigen::Vector2d& point_m, double range_m) const;
  /// The scan without the returns that are explained: NaN.
  [[nodiscard]] LaserScan unexplained(const LaserScan& scan, const Pose2& map_T_sensor) const;

 private:
  OccupancyGrid away_;  ///< cells to the nearest obstacle
  double margin_m_{0};
};

}  // namespace extperfc::navigate
