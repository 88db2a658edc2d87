#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/navigate/cost_map.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// A simple polygon of the map's frame.
struct Zone {
  std::string name;
  std::vector<Eigen::Vector2d> corners_m;  ///< counter-clockwise
};

struct SpeedZone : Zone {
  double factor{1};  ///< of the limits of speed, (0, 1]; [0.01, 1] in files
};

/// Where the robot must not drive, and where it must drive slowly; in the map's frame.
struct Zones {
  std::vector<Zone> keep_out;
  std::vector<OccupancyGrid> keep_out_maps;  ///< their occupied cells are kept out of
  std::vector<SpeedZone> speed;
};

/// Reads zones from a YAML file:
///   keep_out:                                # both lists may be missing
///     - {name: stairs, polygon: [[0, 0], [1, 0], [1, 2]]}    # 3 to 200 corners [m]
///     - {name: lift, map: lift.yaml}                         # a map of map_server; relative to this file
///   speed:
///     - {name: corridor, factor: 0.5, polygon: [[5, 0], [9, 0], [9, 2], [5, 2]]}
/// Errors name every problem with its line.
[[nodiscard]] Result<Zones> load_zones(const std::filesystem::path& file);

/// Keep-out zones are lethal: each cell that overlaps one. Speed zones cost nothing.
class ZoneLayer : public CostLayer {
 public:
  /// Throws std::invalid_argument for a polygon that is not simple or a factor out of its range.
  void set_zones(Zones zones);
  /// Pose of the map's frame in the grid's. Precondition: finite. Costs change only where there are keep-out
  /// zones and the pose is another one.
  void set_pose(const Pose2& grid_T_map);
  /// The smallest factor of the zones that hold a point of the grid's frame; 1 elsewhere.
  [[nodiscard]] double speed_factor_at(const Eigen::Vector2d& point_m) const;

  void match(const CostGrid& grid) override;
  [[nodiscard]] CellBox take_changes(const CostGrid& grid, double now_s) override;
  void write(CostGrid& grid, const CellBox& box) override;

 private:
  [[nodiscard]] bool has_keep_out() const;
  void draw();

  Zones zones_;
  std::vector<std::vector<Eigen::Vector2d>> parts_m_;  ///< convex, of all keep-out polygons
  Pose2 grid_T_map_;
  CostGrid costs_;  ///< lethal or free
  bool changed_{false};
};

}  // namespace extperfc::navigate
