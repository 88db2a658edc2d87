#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "mapping/surface_map.hpp"

namespace extperfc::mapping {

/// Where a surface of any direction lies in the cell or next to it: a bit per cell, of the map as it is now.
/// Made in O(surfaces + area), for searches that ask a hundred thousand times.
class NearMask {
 public:
  explicit NearMask(const SurfaceMap& map);

  /// `point` in the map's frame [m].
  [[nodiscard]] bool at(const Eigen::Vector2f& point) const {
    const int column = SurfaceMap::cell_index(point.x()) - first_column_;
    const int row = SurfaceMap::cell_index(point.y()) - first_row_;
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return false;
    return (blocks_[block(column, row)] >> (column & 63) & 1U) != 0;
  }

 private:
  [[nodiscard]] std::size_t block(int column, int row) const {
    return static_cast<std::size_t>(row) * blocks_per_row_ + static_cast<std::size_t>(column >> 6);
  }

  int first_column_{0};
  int first_row_{0};
  int columns_{0};
  int rows_{0};
  std::size_t blocks_per_row_{0};
  std::vector<std::uint64_t> blocks_;
};

}  // namespace extperfc::mapping
