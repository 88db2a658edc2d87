#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "extperfc/world/pose.hpp"

namespace extperfc {

/// A map of square cells as nav_msgs/OccupancyGrid has it: row by row from the lower left corner.
struct OccupancyGrid {
  static constexpr std::int8_t kUnknown = -1;
  static constexpr std::int8_t kFree = 0;
  static constexpr std::int8_t kOccupied = 100;

  std::size_t width{0};            ///< cells
  std::size_t height{0};           ///< cells
  double resolution_m{0.05};       ///< side of a cell [m]
  Pose2 origin;                    ///< pose of the lower left corner of cell (0, 0) in the map's frame
  std::vector<std::int8_t> cells;  ///< width * height; -1 unknown, else 0 (free) to 100 (occupied) [percent]

  struct Cell {
    std::size_t column{0};
    std::size_t row{0};
  };

  [[nodiscard]] bool empty() const { return cells.empty(); }
  [[nodiscard]] std::int8_t at(std::size_t column, std::size_t row) const {
    return cells[row * width + column];
  }
  /// The cell that holds a point of the map's frame [m]; empty outside the grid.
  [[nodiscard]] std::optional<Cell> cell_of(double x_m, double y_m) const;
  /// The middle of a cell in the map's frame; its yaw is the grid's.
  [[nodiscard]] Pose2 middle_of(Cell cell) const;
};

}  // namespace extperfc
