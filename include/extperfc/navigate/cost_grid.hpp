#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace extperfc::navigate {

/// Costs of cells, as costmap_2d has them.
using Cost = std::uint8_t;
inline constexpr Cost kFreeCost = 0;
inline constexpr Cost kInscribedCost = 253;  ///< the base's centre here: the footprint surely touches
inline constexpr Cost kLethalCost = 254;     ///< an obstacle
inline constexpr Cost kUnknownCost = 255;    ///< never free

struct Cell {
  int column{0};
  int row{0};
};

/// A rectangle of cells; half open: max is not part of it. Empty unless min < max in both.
struct CellBox {
  Cell min;
  Cell max;

  [[nodiscard]] bool empty() const { return min.column >= max.column || min.row >= max.row; }
  /// The smallest box around both; an empty one adds nothing.
  [[nodiscard]] CellBox joined(const CellBox& other) const;
  /// The cells of both; perhaps empty.
  [[nodiscard]] CellBox clipped(const CellBox& other) const;
  [[nodiscard]] CellBox grown(int cells) const;
};

/// costmap_2d's costs around lethal cells, by the distance d between the middles of two cells: kLethalCost at
/// 0, kInscribedCost up to inscribed_radius_m, 252 exp(-cost_scaling_factor (d - inscribed_radius_m)) up to
/// radius_m, 0 beyond.
struct Inflation {
  double inscribed_radius_m{0};    ///< [0, radius_m]
  double radius_m{0};              ///< 0: costs do not spread
  double cost_scaling_factor{10};  ///< [1/m], >= 0

  [[nodiscard]] Cost cost_at(double distance_m) const;
};

/// Square cells along the axes of a frame (map or odom), row by row from the lower left corner.
struct CostGrid {
  int width{0};                                       ///< cells
  int height{0};                                      ///< cells
  double resolution_m{0.05};                          ///< side of a cell [m]
  Eigen::Vector2d origin_m{Eigen::Vector2d::Zero()};  ///< lower left corner of cell (0, 0) [m]
  std::vector<Cost> cells;                            ///< width * height
  /// Around every lethal cell costs are at least these; contact() concludes from the cost of one cell.
  Inflation inflation{};
  bool may_hold_unknown{true};  ///< false: surely no cell is of kUnknownCost

  [[nodiscard]] bool empty() const { return cells.empty(); }
  [[nodiscard]] CellBox box() const { return {{0, 0}, {width, height}}; }
  [[nodiscard]] bool contains(Cell cell) const {
    return cell.column >= 0 && cell.row >= 0 && cell.column < width && cell.row < height;
  }
  [[nodiscard]] std::size_t index(Cell cell) const {
    return static_cast<std::size_t>(cell.row) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(cell.column);
  }
  /// Precondition: contains(cell).
  [[nodiscard]] Cost at(Cell cell) const { return cells[index(cell)]; }
  [[nodiscard]] Cost& at(Cell cell) { return cells[index(cell)]; }
  /// The cell that holds a point [m], also outside the grid. Precondition: finite, within 1e8 cells of it.
  [[nodiscard]] Cell cell_around(const Eigen::Vector2d& point_m) const;
  /// The same, empty outside the grid.
  [[nodiscard]] std::optional<Cell> cell_of(const Eigen::Vector2d& point_m) const;
  [[nodiscard]] Eigen::Vector2d middle_of(Cell cell) const {
    return origin_m + resolution_m * Eigen::Vector2d(cell.column + 0.5, cell.row + 0.5);
  }
};

/// A grid of one cost. Throws std::invalid_argument unless 0 < width, height <= 30000 and resolution_m > 0.
[[nodiscard]] CostGrid make_cost_grid(int width, int height, double resolution_m,
                                      const Eigen::Vector2d& origin_m, Cost cost);

}  // namespace extperfc::navigate
