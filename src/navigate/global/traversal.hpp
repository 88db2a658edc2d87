#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/cost_grid.hpp"

namespace extperfc::navigate {

/// A disc of the floor [cells of the cost grid].
struct Disc {
  Eigen::Vector2d middle{Eigen::Vector2d::Zero()};
  double radius{0};

  [[nodiscard]] bool holds(const Eigen::Vector2d& point) const {
    return (point - middle).squaredNorm() <= radius * radius;
  }
};

/// Which cells a search may cross, and their cost per cell of length.
struct Traversal {
  std::array<float, 256> weight{};  ///< of a cost; 0: not admissible
  double inscribed_cells{0};        ///< kept from lethal cells that are not inflated and from unknown ones
  std::vector<Disc> opened;         ///< inscribed cells here weigh as much as the dearest others
  std::vector<Disc> closed;         ///< here no cell is admissible

  [[nodiscard]] bool admits(Cost cost) const { return weight[cost] > 0; }
};

}  // namespace extperfc::navigate
