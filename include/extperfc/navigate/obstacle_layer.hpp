#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/navigate/cost_map.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

struct ObstacleParams {
  double keep_s{0.3};         ///< a ray clears no cell that was marked less than this before it, >= 0 [s]
  double decay_s{3};          ///< a cell between rays that pass it is cleared so long after its last mark [s]
  double unseen_decay_s{60};  ///< so long after its last mark every cell is cleared, > 0; infinity: never [s]
  double height_tolerance_m{0.1};  ///< a ray clears what was marked at its height, up to this, >= 0
  bool frees_unknown{false};       ///< rays make unknown cells of the layers before free
  double blind_m{0};               ///< marks so near to the last scan's place do not age, >= 0
};

/// What the data of one sensor do.
struct SensorParams {
  bool marks{true};
  bool clears{true};
  double obstacle_range_m{4};          ///< returns beyond mark nothing, > 0
  double raytrace_range_m{5};          ///< rays clear up to here, > 0
  double min_obstacle_height_m{0.05};  ///< of points that mark [m]
  double max_obstacle_height_m{1.6};   ///< the same
  bool inf_is_valid{false};            ///< +infinity in a scan clears up to range_max
  /// Of a scan with heights: rays clear what was last seen at heights within this angle about the horizontal
  /// of the scanner [rad], [0, pi / 2).
  double half_fov_rad{0};
};

/// Points of a cloud in the grid's frame, z from the floor.
struct PointObservation {
  double stamp_s{0};
  Eigen::Vector3d sensor_m{Eigen::Vector3d::Zero()};  ///< position of the sensor, the same frame
  std::vector<Eigen::Vector3f> points_m;              ///< those that are not finite say nothing
};

/// What sensors see now. A return marks its cell with its height. A ray clears the cells before its return
/// that were marked at its height; one that passes above or below says nothing. NaN, zero and too short
/// ranges neither mark nor clear. What no sensor sees stays until unseen_decay_s after its last mark, within
/// blind_m of the scanner for good.
class ObstacleLayer : public CostLayer {
 public:
  /// Throws std::invalid_argument for parameters out of their range.
  explicit ObstacleLayer(const ObstacleParams& params = {});

  /// A scan of a scanner `height_m` above the floor. One with heights marks them, and clears marks that the
  /// scanner could see from where it is: a table that a lidar with few rings saw from afar stays when it
  /// comes too near to see it. Errors: a scan that cannot be, a pose that is not finite; the layer does not
  /// change then. O(marked cells + cells of rays towards cells that may be cleared).
  [[nodiscard]] Result<void> observe(const LaserScan& scan, const Pose2& grid_T_sensor, double height_m,
                                     const SensorParams& sensor);
  /// Errors: a stamp or position of the sensor that is not finite.
  [[nodiscard]] Result<void> observe(const PointObservation& cloud, const SensorParams& sensor);
  /// The robot stands here: no obstacle in cells whose middle is under the footprint, and with frees_unknown
  /// no unknown cell, though no ray reaches them.
  void clear_footprint(const Footprint& footprint, const Pose2& grid_T_base);
  /// A person stands or walks here: marks within `radius_m` count as seen at `height_m`, so that they are
  /// cleared when the place is free. O(marked cells).
  void level(const Eigen::Vector2d& middle_m, double radius_m, double height_m);
  /// Forgets marks farther than `radius_m` from a point.
  void clear_beyond(const Eigen::Vector2d& middle_m, double radius_m);
  [[nodiscard]] std::size_t marked_cells() const { return marks_.size(); }

  void match(const CostGrid& grid) override;
  [[nodiscard]] CellBox take_changes(const CostGrid& grid, double now_s) override;
  void write(CostGrid& grid, const CellBox& box) override;
  void clear() override;

 private:
  struct Mark {
    std::size_t index;  ///< of the cell
    double stamp_s;     ///< of the last return
    float low_m;        ///< heights of returns
    float high_m;

    void join(const Mark& other);
  };
  struct Ray {
    Eigen::Vector3d end_m;
    double range_m;  ///< on the floor
    bool returned;   ///< false: met nothing up to its end
  };
  struct Band {
    double low_m;
    double high_m;
  };
  struct Observation {
    double stamp_s;
    Eigen::Vector3d sensor_m;
    std::vector<Ray> rays;
    std::optional<double> rise{};  ///< rays are fans that rise and fall by this per metre; empty: lines
  };

  void take(const Observation& observation, const SensorParams& sensor, const Band& marked);
  void mark(const Ray& ray, double stamp_s, bool fan);
  void clear_along(const Observation& observation, const Ray& ray, double raytrace_range_m);
  void pass(std::size_t index, const Band& heights, double stamp_s, bool fan);
  [[nodiscard]] bool is_seen(const Mark& mark, const Band& heights, bool fan) const;
  void clear_between_rays(const LaserScan& scan, const Pose2& grid_T_sensor, double height_m,
                          const SensorParams& sensor);
  /// By the angle from the sensor; empty when no cell may be cleared.
  [[nodiscard]] std::vector<bool> directions_to_clear(const Observation& observation,
                                                      double raytrace_range_m) const;
  [[nodiscard]] bool may_clear(const Mark& mark, double stamp_s) const {
    return stamp_s - mark.stamp_s > params_.keep_s;
  }
  [[nodiscard]] Cell cell_at(std::size_t index) const;
  void erase(std::size_t slot);
  void note_change(std::size_t index);

  ObstacleParams params_;
  CostGrid shape_;                   ///< geometry of the grid, without cells
  std::vector<std::int32_t> slots_;  ///< of each cell: its mark, or one of the two below
  std::vector<Mark> marks_;
  std::optional<Eigen::Vector2d> scanner_m_;  ///< of the last scan
  CellBox changed_;
};

}  // namespace extperfc::navigate
