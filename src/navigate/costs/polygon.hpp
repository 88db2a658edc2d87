#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"

namespace extperfc::navigate {

/// Corners of a polygon [m]; the last is joined with the first.
using Polygon = std::vector<Eigen::Vector2d>;
/// What is smaller is no outline [m^2].
inline constexpr double kSmallestArea_m2 = 1e-4;

/// Above 0: b is to the left of the ray from `origin` through a.
[[nodiscard]] inline double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Above 0 for counter-clockwise corners [m^2].
[[nodiscard]] double signed_area_m2(const Polygon& polygon);
/// Whether no two edges meet but neighbours at their common corner. O(n^2).
[[nodiscard]] bool is_simple(const Polygon& polygon);
/// Whether no corner of a simple, counter-clockwise polygon is a dent.
[[nodiscard]] bool is_convex(const Polygon& polygon);
/// Whether a simple polygon holds the point; either on its edges.
[[nodiscard]] bool contains(const Polygon& polygon, const Eigen::Vector2d& point_m);
/// Distance of a point from the edges [m].
[[nodiscard]] double distance_to_edges_m(const Polygon& polygon, const Eigen::Vector2d& point_m);
/// Counter-clockwise, without corners on straight edges. Fewer than 3 corners when the points are on a line.
[[nodiscard]] Polygon convex_hull(Polygon points_m);
/// A simple, counter-clockwise polygon cut into convex ones: itself, or triangles by ear clipping. O(n^3) at
/// worst.
[[nodiscard]] std::vector<Polygon> convex_parts(const Polygon& polygon);
/// Without repeated corners and counter-clockwise. Errors: fewer than 3 or more than `max_corners` corners,
/// not finite, edges that cross or touch, an area below kSmallestArea_m2.
[[nodiscard]] Result<Polygon> make_polygon(Polygon corners_m, std::size_t max_corners);

}  // namespace extperfc::navigate
