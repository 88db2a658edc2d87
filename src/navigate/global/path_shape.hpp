#pragma once

#include <optional>
#include <vector>

#include "extperfc/navigate/global_planner.hpp"

#include "navigate/global/cell_space.hpp"
#include "navigate/global/grid_search.hpp"

namespace extperfc::navigate {

/// Path cost along a polyline [cells]; infinite where it leaves what is admissible.
[[nodiscard]] double cost_along(CellSpace& cells, const Polyline& line);

/// The first place of a line that is not admissible [cells], to a quarter of a cell.
[[nodiscard]] std::optional<Eigen::Vector2d> first_blocked(CellSpace& cells, const Polyline& line);

/// String pulling: corners are removed or moved as long as the path cost falls. The ends stay. Never leaves
/// what is admissible.
[[nodiscard]] Polyline pull(CellSpace& cells, Polyline line);

/// Points at most `spacing` apart [cells], moved so that curvature changes little from one to the next
/// (descent of the squared second differences), inside what is admissible and for at most 1 % more path cost.
[[nodiscard]] Polyline smooth(CellSpace& cells, const Polyline& line, double spacing);

/// Poses along points [m] from the start to the goal. A differential base heads along the path and rotates in
/// place where it bends by more than 0.2 rad, at the start and at the goal. A holonomic base's yaw minimizes
/// the squared distance from the path's direction, weighed by heading_weight, and the squared rotation per
/// metre.
[[nodiscard]] std::vector<Pose2> add_headings(const std::vector<Eigen::Vector2d>& points_m,
                                              const Pose2& start, const Pose2& goal,
                                              const GridPlannerParams& params);

/// Poses between those farther apart than 0.1 m or 0.2 rad.
[[nodiscard]] std::vector<Pose2> densify(const std::vector<Pose2>& poses);

}  // namespace extperfc::navigate
