#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/cost_grid.hpp"

namespace extperfc::navigate {

/// One source of costs. A layer keeps its own state; the cost map asks it what changed and lets it write
/// there. Called by one thread at a time. A user's layer derives from this and is loaded by pluginlib.
class CostLayer {
 public:
  virtual ~CostLayer() = default;
  /// The master grid was resized or moved: `grid` has the new geometry. The layer keeps what it knows inside.
  virtual void match(const CostGrid& grid) = 0;
  /// Cells whose cost of this layer changed since the last call; the cost map recomputes no others.
  [[nodiscard]] virtual CellBox take_changes(const CostGrid& grid, double now_s) = 0;
  /// Writes this layer's costs into the cells of `box`, which is inside the grid; layers before it have
  /// written already. Cells outside the box hold the costs of all layers.
  virtual void write(CostGrid& grid, const CellBox& box) = 0;
  /// How far a change of the layers before reaches into this layer's costs [cells]; above 0 for inflation.
  [[nodiscard]] virtual int reach_cells(const CostGrid& /*grid*/) const { return 0; }
  /// Forgets what sensors saw; a static map stays.
  virtual void clear() {}
};

/// Layers in order over one grid: costmap_2d's LayeredCostmap. Work grows with what changed, not with the
/// map. One thread at a time.
class CostMap {
 public:
  /// `grid` has the geometry, and the cost where no layer writes (free or unknown) in all its cells. Throws
  /// std::invalid_argument when it is empty.
  explicit CostMap(const CostGrid& grid);
  /// Behind the layers that are there. Throws std::invalid_argument for nullptr.
  void add(std::shared_ptr<CostLayer> layer);
  /// New geometry; everything is recomputed with the next update(). Throws as the constructor does.
  void resize(const CostGrid& grid);
  /// Rolling window: moves the grid by whole cells so that `centre_m` is at most half a cell from its middle.
  /// Layers keep what they know about the cells that stay. Ignores what is not finite.
  void centre_on(const Eigen::Vector2d& centre_m);
  /// Brings the grid up to date and returns the cells that may have changed.
  CellBox update(double now_s);
  [[nodiscard]] const CostGrid& grid() const { return grid_; }
  /// clear() of every layer.
  void clear();
  /// Cells that update() has recomputed since the beginning.
  [[nodiscard]] std::size_t cells_written() const { return cells_written_; }

 private:
  void match();
  [[nodiscard]] std::size_t count_unknown(const CellBox& box) const;

  CostGrid grid_;
  Cost default_cost_;
  CellBox stale_;
  std::size_t unknown_cells_{0};
  std::size_t cells_written_{0};
  std::vector<std::shared_ptr<CostLayer>> layers_;
};

}  // namespace extperfc::navigate
