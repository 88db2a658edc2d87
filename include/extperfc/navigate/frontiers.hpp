#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/nav_error.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

struct FrontierParams {
  double min_length_m{0.4};        ///< shorter frontiers do not count, > 0
  double max_length_m{4};          ///< longer ones are cut, >= min_length_m
  double gain_weight{1};           ///< metres of path that a metre of frontier is worth, >= 0
  double max_standoff_m{2};        ///< goals are at most so far from their frontier, > 0
  double start_tolerance_m{1};     ///< a start that is not free is moved at most this far, >= 0
  double blacklist_radius_m{0.5};  ///< frontiers with a goal this near a blacklisted one are left out, >= 0
  bool allow_unknown{false};       ///< goals and paths may touch unknown cells
  /// Paths lead through gaps narrower than the robot by up to twice this: cells are a little wrong, and who
  /// plans the drive knows better; >= 0.
  double passage_slack_m{0.05};
};

struct FrontierQuery {
  Pose2 start;                              ///< of the base, in the grid's frame
  std::vector<Eigen::Vector2d> bounds_m{};  ///< a polygon: frontiers outside do not count; empty: all count
  std::vector<Eigen::Vector2d> blacklist_m{};  ///< positions of goals that failed
};

/// A border between free and unknown cells.
struct Frontier {
  std::vector<Eigen::Vector2d> points_m;  ///< middles of its free cells where the inscribed circle may be
  double length_m{0};                     ///< number of cells times their side, with those beside obstacles
  Eigen::Vector2d centroid_m{Eigen::Vector2d::Zero()};
  Pose2 goal;        ///< of the base: free, and heading to the frontier where the footprint allows
  double path_m{0};  ///< from the start to the goal
  double score{0};   ///< gain_weight length_m - path_m
};

struct FrontierList {
  std::vector<Frontier> frontiers;  ///< best score first
  std::size_t blacklisted{0};       ///< frontiers that were left out for that
  std::size_t without_goal{0};      ///< the same where the footprint fits nowhere near
};

/// Frontiers (Yamauchi, "A frontier-based approach for autonomous exploration", 1997) where the robot could
/// go on: their cells are connected with the start by free cells that are farther from lethal cells than the
/// inscribed radius without the slack; their own distance is more by half of the slack. So gaps narrower than
/// the robot and ragged walls are none. Paths keep that radius from unknown cells too, unless allow_unknown.
/// None is left when the floor is mapped. Errors: kStartOutside, kStartBlocked, kInvalidRequest for values
/// that are not finite or out of their range. O(cells log cells).
[[nodiscard]] NavResult<FrontierList> find_frontiers(const CostGrid& costs, const Footprint& footprint,
                                                     const FrontierQuery& query,
                                                     const FrontierParams& params);

}  // namespace extperfc::navigate
