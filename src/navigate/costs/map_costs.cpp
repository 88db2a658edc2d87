#include "navigate/costs/map_costs.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "navigate/costs/row_spans.hpp"

namespace extperfc::navigate {

namespace {

using Eigen::Vector2d;

/// The map's cells as a CostGrid in the frame of its lower left corner, without cells.
CostGrid shape_of(const OccupancyGrid& map) {
  CostGrid shape;
  shape.width = static_cast<int>(map.width);
  shape.height = static_cast<int>(map.height);
  shape.resolution_m = map.resolution_m;
  return shape;
}

std::uint8_t value_at(const OccupancyGrid& map, Cell cell) {
  return static_cast<std::uint8_t>(
      map.at(static_cast<std::size_t>(cell.column), static_cast<std::size_t>(cell.row)));
}

int rank(Cost cost) {
  if (cost == kOutsideMap) return -1;
  return cost == kUnknownCost ? kLethalCost - 1 : cost;
}

/// The cell of a box that holds a point [cells].
std::optional<Cell> cell_in(const CellBox& box, const Vector2d& in_cells) {
  const Vector2d whole = in_cells.array().floor();
  if (!(whole.x() >= box.min.column && whole.y() >= box.min.row && whole.x() < box.max.column &&
        whole.y() < box.max.row))
    return std::nullopt;
  return Cell{static_cast<int>(whole.x()), static_cast<int>(whole.y())};
}

/// Column and row of the grid at the map's cell (0, 0) when cells are on cells.
struct Offset {
  bool aligned{false};
  int column{0};
  int row{0};
};

Offset offset_of(const OccupancyGrid& map, const Pose2& grid_T_corner, const CostGrid& grid) {
  constexpr double kTolerance = 1e-3;  // [cells], over the whole map
  const double longest = static_cast<double>(std::max(map.width, map.height));
  const double rotation = std::abs(wrap_angle(grid_T_corner.yaw)) * longest;
  const double stretch = std::abs(map.resolution_m / grid.resolution_m - 1) * longest;
  const Vector2d corner = (Vector2d(grid_T_corner.x, grid_T_corner.y) - grid.origin_m) / grid.resolution_m;
  const Vector2d whole = corner.array().round();
  const double off = (corner - whole).cwiseAbs().maxCoeff();
  constexpr double kMaxOffset = 1e8;
  if (!(rotation + stretch + off < kTolerance && whole.cwiseAbs().maxCoeff() < kMaxOffset)) return {};
  return {true, static_cast<int>(whole.x()), static_cast<int>(whole.y())};
}

void copy_aligned(const OccupancyGrid& map, const Offset& offset, const CostOfValue& cost_of, CostGrid& grid,
                  const CellBox& box) {
  const CellBox map_box{
      {offset.column, offset.row},
      {offset.column + static_cast<int>(map.width), offset.row + static_cast<int>(map.height)}};
  const CellBox both = box.clipped(map_box);
  for (int row = both.min.row; row < both.max.row; ++row)
    for (int column = both.min.column; column < both.max.column; ++column)
      grid.at({column, row}) = cost_of[value_at(map, {column - offset.column, row - offset.row})];
}

/// Each cell takes the value of the map's cell that holds its middle.
void take_middles(const OccupancyGrid& map, const Pose2& corner_T_grid, const CostOfValue& cost_of,
                  CostGrid& grid, const CellBox& box) {
  const CostGrid shape = shape_of(map);
  const ToCells to_map(shape, corner_T_grid);
  for (int row = box.min.row; row < box.max.row; ++row) {
    for (int column = box.min.column; column < box.max.column; ++column) {
      const auto cell = cell_in(shape.box(), to_map(grid.middle_of({column, row})));
      if (cell) grid.at({column, row}) = cost_of[value_at(map, *cell)];
    }
  }
}

/// Each of the map's cells adds its cost to the cell that holds its middle.
void add_middles(const OccupancyGrid& map, const Pose2& grid_T_corner, const CostOfValue& cost_of,
                 CostGrid& grid, const CellBox& box) {
  const CostGrid shape = shape_of(map);
  const Vector2d low = grid.origin_m + grid.resolution_m * Vector2d(box.min.column, box.min.row);
  const Vector2d high = grid.origin_m + grid.resolution_m * Vector2d(box.max.column, box.max.row);
  const ToCells to_map(shape, inverse(grid_T_corner));
  const Polygon corners{low, {high.x(), low.y()}, high, {low.x(), high.y()}};
  const ToCells to_grid(grid, grid_T_corner);
  visit_rows(shape, corners, to_map, Bounds(corners, to_map), [&](int row, int begin, int end) {
    for (int column = begin; column < end; ++column) {
      const auto cell = cell_in(box, to_grid(shape.middle_of({column, row})));
      if (cell) grid.at(*cell) = worse_of(grid.at(*cell), cost_of[value_at(map, {column, row})]);
    }
    return true;
  });
}

}  // namespace

Cost worse_of(Cost a, Cost b) {
  return rank(a) >= rank(b) ? a : b;
}

void draw_map(const OccupancyGrid& map, const Pose2& grid_T_map, const CostOfValue& cost_of, CostGrid& grid,
              const CellBox& box) {
  if (map.empty() || box.empty()) return;
  const Pose2 grid_T_corner = compose(grid_T_map, map.origin);
  if (const Offset offset = offset_of(map, grid_T_corner, grid); offset.aligned)
    return copy_aligned(map, offset, cost_of, grid, box);
  take_middles(map, inverse(grid_T_corner), cost_of, grid, box);
  add_middles(map, grid_T_corner, cost_of, grid, box);
}

CellBox cells_under(const OccupancyGrid& map, const CellBox& map_box, const Pose2& grid_T_map,
                    const CostGrid& grid) {
  const double r = map.resolution_m;
  const Vector2d low = r * Vector2d(map_box.min.column, map_box.min.row);
  const Vector2d high = r * Vector2d(map_box.max.column, map_box.max.row);
  const Bounds bounds({low, {high.x(), low.y()}, high, {low.x(), high.y()}},
                      ToCells(grid, compose(grid_T_map, map.origin)));
  // Middles of the grid's cells may be up to half a cell away.
  const auto bounded = [](double value) { return static_cast<int>(std::clamp(value, -1e8, 1e8)); };
  return CellBox{{bounded(std::floor(bounds.columns.low)), bounded(std::floor(bounds.rows.low))},
                 {bounded(std::ceil(bounds.columns.high)), bounded(std::ceil(bounds.rows.high))}}
      .grown(1);
}

}  // namespace extperfc::navigate
