#pragma once

#include <Eigen/Core>

#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// Which returns of a scanner the static map explains: those within a margin of one of its obstacles, along
/// each of its axes. Localization and cells are a little wrong, so such a return is no news.
class MapExplanation {
 public:
  /// Until then nothing is explained. O(cells + occupied cells * cells of the margin).
  void set_map(const OccupancyGrid& map, double margin_m);
  [[nodiscard]] bool explains(const Eigen::Vector2d& point_m) const;
  /// The scan without the returns that are explained: NaN.
  [[nodiscard]] LaserScan unexplained(const LaserScan& scan, const Pose2& map_T_sensor) const;

 private:
  OccupancyGrid near_;  ///< kOccupied within the margin of an obstacle
};

}  // namespace extperfc::navigate
