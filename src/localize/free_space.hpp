#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "extperfc/base/rng.hpp"
#include "extperfc/world/occupancy_grid.hpp"

namespace extperfc::localize {

/// Draws points of a map's free cells.
class FreeSpace {
 public:
  explicit FreeSpace(std::shared_ptr<const OccupancyGrid> map);

  [[nodiscard]] std::size_t cells() const { return cells_; }

  struct Point {
    float x_m{0};  ///< from the map's lower left corner, along its own axes
    float y_m{0};
  };
  /// Uniform over the free area. There must be a free cell.
  [[nodiscard]] Point draw(Rng& rng) const;

 private:
  std::shared_ptr<const OccupancyGrid> map_;
  std::size_t cells_{0};
  std::vector<std::uint32_t> list_;  ///< of the free cells, where they are too rare to be found by guessing
};

}  // namespace extperfc::localize
