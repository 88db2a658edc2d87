#pragma once

#include <array>
#include <cstdint>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// Cost of each value that a cell of a map may have, by its bits.
using CostOfValue = std::array<Cost, 256>;

/// Of cells about which a map says nothing: no map has this cost.
inline constexpr Cost kOutsideMap = kInscribedCost;

/// Outside, then free, then costs, then unknown, then lethal.
[[nodiscard]] Cost worse_of(Cost a, Cost b);

/// Writes what a map says about the cells of `box`, which is inside the grid: see StaticLayer. Cells outside
/// the map are left. O(cells of the box + cells of the map in it).
void draw_map(const OccupancyGrid& map, const Pose2& grid_T_map, const CostOfValue& cost_of, CostGrid& grid,
              const CellBox& box);

/// Cells of the grid that a rectangle of the map's cells may have a part in; perhaps outside the grid.
[[nodiscard]] CellBox cells_under(const OccupancyGrid& map, const CellBox& map_box, const Pose2& grid_T_map,
                                  const CostGrid& grid);

}  // namespace extperfc::navigate
