#pragma once

#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate::test {

inline std::vector<Eigen::Vector2d> moved(const std::vector<Eigen::Vector2d>& corners, const Pose2& pose) {
  std::vector<Eigen::Vector2d> result;
  for (const auto& corner : corners) {
    const Pose2 placed = compose(pose, {corner.x(), corner.y(), 0});
    result.emplace_back(placed.x, placed.y);
  }
  return result;
}

/// The part of a polygon with `axis` at or above (sign 1) or at or below (sign -1) a limit, by Sutherland and
/// Hodgman: dents leave edges without area.
inline std::vector<Eigen::Vector2d> clipped(const std::vector<Eigen::Vector2d>& polygon, int axis,
                                            double sign, double limit) {
  std::vector<Eigen::Vector2d> result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    const double da = sign * (a[axis] - limit);
    const double db = sign * (b[axis] - limit);
    if (da >= 0) result.push_back(a);
    if ((da < 0) != (db < 0)) result.emplace_back(a + da / (da - db) * (b - a));
  }
  return result;
}

/// Area of a polygon inside a cell [m^2].
inline double overlap_m2(const CostGrid& grid, Cell cell, std::vector<Eigen::Vector2d> polygon) {
  const Eigen::Vector2d low = grid.middle_of(cell) - Eigen::Vector2d::Constant(grid.resolution_m / 2);
  for (int axis = 0; axis < 2; ++axis) {
    polygon = clipped(polygon, axis, 1, low[axis]);
    polygon = clipped(polygon, axis, -1, low[axis] + grid.resolution_m);
  }
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d a = polygon[i] - low;
    const Eigen::Vector2d b = polygon[(i + 1) % polygon.size()] - low;
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

}  // namespace extperfc::navigate::test
