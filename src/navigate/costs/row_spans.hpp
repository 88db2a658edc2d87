#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/world/pose.hpp"

#include "navigate/costs/polygon.hpp"

namespace extperfc::navigate {

/// Overlaps thinner than this do not count, so that a polygon along the cells' sides covers no neighbours
/// [cells].
inline constexpr double kMinOverlap = 1e-6;

/// Points of a frame in cells from the grid's lower left corner.
class ToCells {
 public:
  ToCells(const CostGrid& grid, const Pose2& grid_T_frame)
      : cos_(std::cos(grid_T_frame.yaw) / grid.resolution_m),
        sin_(std::sin(grid_T_frame.yaw) / grid.resolution_m),
        x_((grid_T_frame.x - grid.origin_m.x()) / grid.resolution_m),
        y_((grid_T_frame.y - grid.origin_m.y()) / grid.resolution_m) {}

  [[nodiscard]] Eigen::Vector2d operator()(const Eigen::Vector2d& point_m) const {
    return {cos_ * point_m.x() - sin_ * point_m.y() + x_, sin_ * point_m.x() + cos_ * point_m.y() + y_};
  }

 private:
  double cos_;
  double sin_;
  double x_;
  double y_;
};

/// An interval; nothing as it begins.
struct Extent {
  double low{std::numeric_limits<double>::infinity()};
  double high{-std::numeric_limits<double>::infinity()};

  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] bool is_finite() const { return std::isfinite(low) && std::isfinite(high); }
};

/// The cells from `begin` to before `end` that an interval overlaps, of those from 0 to before `count`.
struct CellRange {
  CellRange(const Extent& extent, int count) {
    const double low = std::clamp(extent.low + kMinOverlap, 0.0, static_cast<double>(count));
    const double high = std::clamp(extent.high - kMinOverlap, 0.0, static_cast<double>(count));
    begin = static_cast<int>(low);
    end = static_cast<int>(high);
    if (end < high) ++end;
  }
  int begin{0};
  int end{0};
};

/// One side of a convex polygon from its lowest corner upwards.
class RisingSide {
 public:
  /// `step` is 1 for the side that follows counter-clockwise, size - 1 for the other one.
  RisingSide(const Polygon& convex_m, const ToCells& to_cells, std::size_t lowest, std::size_t step)
      : convex_m_(convex_m),
        to_cells_(to_cells),
        step_(step),
        index_(lowest),
        begin_(to_cells(convex_m[lowest])),
        x_(begin_.x()) {
    find_end();
  }

  /// Adds what lies between the last height and this one [cells].
  void climb(double height, Extent& columns) {
    columns.include(x_);
    while (rises_ && end_.y() <= height) {
      begin_ = end_;
      x_ = begin_.x();
      columns.include(x_);
      find_end();
    }
    if (!rises_ || begin_.y() >= height) return;
    x_ = begin_.x() + (height - begin_.y()) * columns_per_row_;
    columns.include(x_);
  }

 private:
  void find_end() {
    index_ = (index_ + step_) % convex_m_.size();
    end_ = to_cells_(convex_m_[index_]);
    rises_ = end_.y() >= begin_.y() && ++edges_ < convex_m_.size();
    if (end_.y() > begin_.y()) columns_per_row_ = (end_.x() - begin_.x()) / (end_.y() - begin_.y());
  }

  const Polygon& convex_m_;
  const ToCells& to_cells_;
  std::size_t step_;
  std::size_t index_;  ///< of the corner at the edge's upper end
  std::size_t edges_{0};
  bool rises_{false};
  Eigen::Vector2d begin_;  ///< lower end of the edge [cells]
  Eigen::Vector2d end_;    ///< upper end of the edge [cells]
  double columns_per_row_{0};
  double x_;  ///< at the last height [cells]
};

/// Where a convex polygon begins and ends [cells].
struct Bounds {
  Bounds(const Polygon& convex_m, const ToCells& to_cells) {
    for (std::size_t i = 0; i < convex_m.size(); ++i) {
      const Eigen::Vector2d corner = to_cells(convex_m[i]);
      if (corner.y() < rows.low) lowest = i;
      columns.include(corner.x());
      rows.include(corner.y());
    }
  }
  [[nodiscard]] bool is_finite() const { return columns.is_finite() && rows.is_finite(); }
  [[nodiscard]] bool inside(const CostGrid& grid) const {
    return columns.low >= -kMinOverlap && rows.low >= -kMinOverlap &&
           columns.high <= grid.width + kMinOverlap && rows.high <= grid.height + kMinOverlap;
  }

  Extent columns;
  Extent rows;
  std::size_t lowest{0};  ///< corner
};

/// Calls `visit(row, first column, column behind the last)` for each row of cells that a convex, finite
/// polygon overlaps, clipped to the grid, until it returns false. Exact: in each row the polygon's part is
/// one connected set, so the cells that it overlaps are those that its extent overlaps. O(rows + corners).
template <typename Visit>
void visit_rows(const CostGrid& grid, const Polygon& convex_m, const ToCells& to_cells, const Bounds& bounds,
                const Visit& visit) {
  const CellRange rows(bounds.rows, grid.height);
  if (rows.begin >= rows.end) return;
  RisingSide one(convex_m, to_cells, bounds.lowest, 1);
  RisingSide other(convex_m, to_cells, bounds.lowest, convex_m.size() - 1);
  if (bounds.rows.low < rows.begin) {  // what is below the grid
    Extent below;
    one.climb(rows.begin, below);
    other.climb(rows.begin, below);
  }
  for (int row = rows.begin; row < rows.end; ++row) {
    Extent extent;
    one.climb(row + 1, extent);
    other.climb(row + 1, extent);
    const CellRange columns(extent, grid.width);
    if (columns.begin < columns.end && !visit(row, columns.begin, columns.end)) return;
  }
}

}  // namespace extperfc::navigate
