#pragma once

#include <cstddef>
#include <optional>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/path.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// Where on its path the robot is. The path is in the frame map; its poses are at most 0.1 m apart. One
/// thread at a time.
class PathTracker {
 public:
  /// Precondition: not empty.
  void set(Path path);
  void clear() { path_ = {}; }
  [[nodiscard]] bool empty() const { return path_.poses.empty(); }

  /// Moves on to the pose of the path nearest to the robot: near the last one first, so that paths which
  /// cross themselves are followed in order.
  void update(const Pose2& map_T_base);
  [[nodiscard]] double rest_m() const;       ///< that is left, from the nearest pose on [m]
  [[nodiscard]] double deviation_m() const;  ///< from the nearest pose [m]
  [[nodiscard]] const Path& path() const { return path_; }
  /// The rest of the path in another frame.
  [[nodiscard]] Path rest_in(const Pose2& target_T_map) const;
  /// The first pose (in the frame map) of the next `ahead_m` that touches an obstacle of these costs. Poses
  /// outside the costs do not count.
  [[nodiscard]] std::optional<Pose2> blocked(const CostGrid& costs, const Footprint& footprint,
                                             const Pose2& grid_T_map, double ahead_m) const;

 private:
  Path path_;
  std::vector<double> rest_m_;  ///< of every pose to the end
  std::size_t nearest_{0};
  double deviation_m_{0};
};

}  // namespace extperfc::navigate
