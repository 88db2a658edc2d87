#pragma once

#include <memory>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

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
  /// Writes this layer's costs into the cells of `box`; layers before it have written already.
  virtual void write(CostGrid& grid, const CellBox& box) const = 0;
  /// How far a change of the layers before reaches into this layer's costs [cells]; inflation says more than
  /// 0.
  [[nodiscard]] virtual int reach_cells(const CostGrid& /*grid*/) const { return 0; }
  /// Forgets what sensors saw; a static map stays.
  virtual void clear() {}
};

/// Layers in order over one grid: costmap_2d's LayeredCostmap. Work grows with what changed, not with the
/// map. One thread at a time.
class CostMap {
 public:
  /// Precondition: `grid` is not empty; its cells are the cost where no layer writes (free or unknown).
  explicit CostMap(const CostGrid& grid);
  void add(std::shared_ptr<CostLayer> layer);
  /// New geometry; everything is recomputed with the next update().
  void resize(const CostGrid& grid);
  /// Rolling window: moves the grid by whole cells so that `centre_m` is in its middle; what stays is kept.
  void centre_on(const Eigen::Vector2d& centre_m);
  /// Brings the grid up to date and returns the cells that may have changed.
  CellBox update(double now_s);
  [[nodiscard]] const CostGrid& grid() const { return grid_; }
  /// clear() of every layer.
  void clear();

 private:
  CostGrid grid_;
  Cost default_cost_;
  CellBox stale_;
  std::vector<std::shared_ptr<CostLayer>> layers_;
};

}  // namespace extperfc::navigate
