#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include <Eigen/Core>

namespace extperfc::navigate {

/// Visits the squares that a line crosses, in order, from that of `from` to that of `to` (Amanatides and Woo
/// 1987). `visit(column_step, row_step, length)` gets the step that leads out of the square (0, 0 in the last
/// one), and the line's length inside it; false ends the walk, and then the result is false. A line through a
/// corner steps along a row first; `corner` is called before with both steps, and ends the walk the same way.
template <typename Visit, typename Corner>
bool walk_line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Visit visit, Corner corner) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const Eigen::Vector2d delta = to - from;
  const double length = delta.norm();
  const double column = std::floor(from.x());
  const double row = std::floor(from.y());
  int columns = std::abs(static_cast<int>(std::floor(to.x()) - column));  // still to cross
  int rows = std::abs(static_cast<int>(std::floor(to.y()) - row));
  const int right = delta.x() > 0 ? 1 : -1;
  const int up = delta.y() > 0 ? 1 : -1;
  const double per_column = delta.x() != 0 ? length / std::abs(delta.x()) : kInfinite;
  const double per_row = delta.y() != 0 ? length / std::abs(delta.y()) : kInfinite;
  double next_column =
      delta.x() != 0 ? (right > 0 ? column + 1 - from.x() : from.x() - column) * per_column : kInfinite;
  double next_row = delta.y() != 0 ? (up > 0 ? row + 1 - from.y() : from.y() - row) * per_row : kInfinite;
  double travelled = 0;
  while (columns + rows > 0) {
    const bool along_row = rows == 0 || (columns > 0 && next_column <= next_row);
    const double next = along_row ? next_column : next_row;
    if (std::abs(next_column - next_row) < 1e-9 && columns > 0 && rows > 0 && !corner(right, up))
      return false;
    if (!visit(along_row ? right : 0, along_row ? 0 : up, next - travelled)) return false;
    travelled = next;
    (along_row ? next_column : next_row) += along_row ? per_column : per_row;
    --(along_row ? columns : rows);
  }
  return visit(0, 0, std::max(0.0, length - travelled));
}

}  // namespace extperfc::navigate
