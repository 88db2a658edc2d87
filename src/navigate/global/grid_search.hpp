#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "navigate/global/any_angle_search.hpp"
#include "navigate/global/block_space.hpp"
#include "navigate/global/cell_space.hpp"
#include "navigate/global/plan_clock.hpp"
#include "navigate/global/traversal.hpp"

namespace extperfc::navigate {

/// Corners of a path, in cells of the cost grid: cell (0, 0) reaches from (0, 0) to (1, 1).
using Polyline = std::vector<Eigen::Vector2d>;

/// Least path cost for a point on the grid. A search from the goal over blocks of cells estimates the rest of
/// the path for a search from the start over the cells (reverse resumable A*, Silver 2005). The cells beside
/// the path over blocks are searched first, and all others only when no path leads through these.
class GridSearch {
 public:
  enum class Status { kFound, kNoPath, kInterrupted };

  /// Points in cells, both inside the grid. `costs` and `traversal` must live until the next call.
  Status find(const CostGrid& costs, const Traversal& traversal, const Eigen::Vector2d& start,
              const Eigen::Vector2d& goal, const PlanClock& clock);
  /// From start to goal. Precondition: the last find() found one.
  [[nodiscard]] const Polyline& path() const { return path_; }
  /// The cells as the last find() saw them; more lines may be asked for.
  [[nodiscard]] CellSpace& cells() { return cells_; }
  [[nodiscard]] std::size_t expanded_cells() const { return fine_.expanded(); }
  [[nodiscard]] std::size_t expanded_blocks() const { return coarse_.expanded(); }
  /// Memory that is kept between searches.
  [[nodiscard]] std::size_t bytes() const {
    return cells_.bytes() + blocks_.bytes() + fine_.bytes() + coarse_.bytes();
  }

 private:
  CellSpace cells_;
  BlockSpace blocks_;
  AnyAngleSearch<CellSpace> fine_;
  AnyAngleSearch<BlockSpace> coarse_;
  Polyline path_;
};

}  // namespace extperfc::navigate
