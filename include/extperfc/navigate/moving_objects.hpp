#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/local_planner.hpp"
#include "extperfc/navigate/map_explanation.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

struct MovingObjectParams {
  double gap_m{0.15};  ///< neighbouring returns farther apart belong to two clusters, (0, 1]; wider where
                       ///< rays are farther apart than half of it
  double join_m{0.5};  ///< middles of clusters nearer than this are one person's legs, [0, 2]
  double min_radius_m{0.1};   ///< reported at least, (0, max_radius_m]
  double max_radius_m{0.6};   ///< larger clusters are furniture or walls, <= 2
  double map_margin_m{0.2};   ///< returns nearer to an obstacle of the map are explained by it, [0, 2]
  double max_explained{0.5};  ///< fraction of a cluster's returns that the map may explain, [0, 1]
  int min_returns{2};         ///< of a person, >= 1
  double max_range_m{8};      ///< farther returns are too few, > 0
  double old_map_s{3};  ///< a map that grows shows who walks: of them it explains what it showed so long
                        ///< ago, >= 0
};

/// A cluster of returns that may be a person.
struct MovingCandidate {
  Eigen::Vector2d centre_m{Eigen::Vector2d::Zero()};  ///< in the map's frame
  double radius_m{0.1};
  int returns{0};
};

/// Finds in planar scans what may move: clusters of a person's size that the static map does not explain.
/// Whether they move is for a tracker to say. One thread at a time.
class MovingObjectDetector {
 public:
  /// Throws std::invalid_argument for parameters out of their range.
  explicit MovingObjectDetector(const MovingObjectParams& params);

  /// Without a map no return is explained. As MapExplanation::set_map(). `stamp_s`: when it came; one that is
  /// before the last map's begins anew.
  void set_map(const OccupancyGrid& map, double stamp_s = 0);
  /// `pedestrians`: who walks, where they should be now in the map's frame. What is near one of them is
  /// a candidate of its own, however closely another or a wall is passed. Precondition: validate(scan) has a
  /// value. O(rays) without clusters, which are few.
  [[nodiscard]] std::vector<MovingCandidate> detect(
      const LaserScan& scan, const Pose2& map_T_base,
      const std::vector<MovingObstacle>& pedestrians = {}) const;

 private:
  struct Cluster;
  [[nodiscard]] std::vector<Cluster> clusters(const LaserScan& scan, const Pose2& map_T_base,
                                              const std::vector<MovingObstacle>& pedestrians) const;
  [[nodiscard]] bool is_explained(const Eigen::Vector2d& point_m,
                                  const std::vector<MovingObstacle>& pedestrians) const;
  void join(std::vector<Cluster>& clusters, const std::vector<MovingObstacle>& pedestrians) const;
  [[nodiscard]] std::optional<std::pair<std::size_t, std::size_t>> nearest_pair(
      const std::vector<Cluster>& clusters, const std::vector<MovingObstacle>& pedestrians) const;

  MovingObjectParams params_;
  MapHistory maps_;
};

/// The scan without the returns of people, whose positions are in the map's frame: NaN. A margin of 0.15 m
/// about each covers arms, and a step.
[[nodiscard]] LaserScan without(LaserScan scan, const std::vector<MovingObstacle>& people,
                                const Pose2& map_T_sensor);
/// The same for points of the map's frame, at any height.
[[nodiscard]] std::vector<Eigen::Vector3f> without(std::vector<Eigen::Vector3f> points_m,
                                                   const std::vector<MovingObstacle>& people);

}  // namespace extperfc::navigate
