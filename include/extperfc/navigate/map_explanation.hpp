#pragma once

#include <deque>
#include <optional>

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

/// A map that is made meanwhile, now and some time ago: who walks or has just come is in the new one only.
class MapHistory {
 public:
  /// old_s: age from which a map counts as old, >= 0 [s].
  explicit MapHistory(double old_s) : old_s_(old_s) {}

  /// As MapExplanation::set_map(). A stamp before the last one's begins anew.
  void add(const OccupancyGrid& map, double margin_m, double stamp_s);
  /// Explains nothing before the first map.
  [[nodiscard]] const MapExplanation& newest() const;
  /// The newest of those that were old when the newest came; without one, the first.
  [[nodiscard]] const MapExplanation& old() const;
  /// When it came; empty before the first map.
  [[nodiscard]] std::optional<double> old_stamp_s() const;

 private:
  struct DatedMap {
    double stamp_s;
    MapExplanation map;
  };

  double old_s_;
  std::deque<DatedMap> maps_;  ///< the last is the newest, the first the old one
};

}  // namespace extperfc::navigate
