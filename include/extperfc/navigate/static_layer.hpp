#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/navigate/cost_map.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// What the cells of a map cost.
struct StaticParams {
  int lethal_percent{65};  ///< occupancy from which a cell is lethal, [1, 100]
  bool trinary{true};      ///< other known cells are free; false: costs up to 252 by their occupancy
  bool unknown_is_free{false};
};

/// The smallest grid of a map's resolution around the map; on its cells unless its origin is rotated. Throws
/// std::invalid_argument for a map without cells, or larger than a CostGrid may be.
[[nodiscard]] CostGrid grid_around(const OccupancyGrid& map, Cost cost);

/// The map as costs, in grid_around(). Throws as that does.
[[nodiscard]] CostGrid costs_of(const OccupancyGrid& map, const StaticParams& params = {});

/// A map as nav_msgs/OccupancyGrid has it. A cell takes the worst of the map's cells whose middle it holds,
/// and of the one that holds its own middle (free, costs, unknown, lethal in this order): no obstacle of the
/// map is lost for another resolution or rotation. Outside the map it writes nothing. The first layer.
class StaticLayer : public CostLayer {
 public:
  /// Throws std::invalid_argument for parameters out of their range.
  explicit StaticLayer(const StaticParams& params = {});

  /// `grid_T_map`: pose of the map's frame in the grid's. Errors: a map without cells, or whose cells or
  /// geometry cannot be; the former map stays then.
  [[nodiscard]] Result<void> set_map(OccupancyGrid map, const Pose2& grid_T_map = {});
  /// New cells for a rectangle of the map, row by row (map_msgs/OccupancyGridUpdate). Errors: no map, not
  /// inside it, another number of cells.
  [[nodiscard]] Result<void> update_map(const CellBox& map_box, const std::vector<std::int8_t>& cells);
  [[nodiscard]] const OccupancyGrid& map() const { return map_; }

  void match(const CostGrid& grid) override;
  [[nodiscard]] CellBox take_changes(const CostGrid& grid, double now_s) override;
  void write(CostGrid& grid, const CellBox& box) override;

 private:
  void draw(const CellBox& box);

  StaticParams params_;
  OccupancyGrid map_;
  Pose2 grid_T_map_;
  CostGrid costs_;  ///< of this layer; kInscribedCost, which no map has, outside the map
  CellBox changed_;
};

}  // namespace extperfc::navigate
