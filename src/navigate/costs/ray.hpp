#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>

#include "extperfc/navigate/cost_grid.hpp"

namespace extperfc::navigate {

/// The part of a segment inside a grid, as fractions of its length; empty unless enter < leave.
struct Inside {
  double enter{0};
  double leave{1};
};

/// Liang and Barsky's clipping.
[[nodiscard]] inline Inside clip_to(const CostGrid& grid, const Eigen::Vector2d& from,
                                    const Eigen::Vector2d& along) {
  Inside part;
  const Eigen::Vector2d size(grid.width, grid.height);
  for (int axis = 0; axis < 2; ++axis) {
    if (along[axis] == 0) {
      if (from[axis] < 0 || from[axis] >= size[axis]) return {1, 0};
      continue;
    }
    const double a = -from[axis] / along[axis];
    const double b = (size[axis] - from[axis]) / along[axis];
    part.enter = std::max(part.enter, std::min(a, b));
    part.leave = std::min(part.leave, std::max(a, b));
  }
  return part;
}

/// Calls `visit(cell, enter, leave)` for each cell of the grid that a segment passes, from its beginning on,
/// with the fractions of its length between which it is inside (Amanatides and Woo, "A fast voxel traversal
/// algorithm for ray tracing", 1987). Both ends in cells from the grid's corner, finite.
template <typename Visit>
void visit_ray(const CostGrid& grid, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
               const Visit& visit) {
  const Eigen::Vector2d along = to - from;
  const Inside part = clip_to(grid, from, along);
  if (!(part.enter < part.leave)) return;
  const Eigen::Vector2d begin = from + part.enter * along;
  Cell cell{std::clamp(static_cast<int>(begin.x()), 0, grid.width - 1),
            std::clamp(static_cast<int>(begin.y()), 0, grid.height - 1)};
  const auto first_border = [](double position, double step, int index) {
    if (step == 0) return std::numeric_limits<double>::infinity();
    return (index + (step > 0 ? 1 : 0) - position) / step;
  };
  double next_column = first_border(from.x(), along.x(), cell.column);
  double next_row = first_border(from.y(), along.y(), cell.row);
  double enter = part.enter;
  while (true) {
    const double border = std::min(next_column, next_row);
    if (border > enter) visit(cell, enter, std::min(border, part.leave));
    if (border >= part.leave) return;
    enter = border;
    if (next_column <= next_row) {
      cell.column += along.x() > 0 ? 1 : -1;
      next_column += 1 / std::abs(along.x());
    } else {
      cell.row += along.y() > 0 ? 1 : -1;
      next_row += 1 / std::abs(along.y());
    }
    if (!grid.contains(cell)) return;
  }
}

}  // namespace extperfc::navigate
