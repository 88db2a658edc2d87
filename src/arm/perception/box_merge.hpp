#pragma once

#include <vector>

#include "arm/perception/voxel_grid.hpp"

namespace extperfc::arm {

/// Covers cells with boxes that do not overlap and hold nothing else: from the first cell left over, along x,
/// then y, then z as far as all cells are there. `cells` are indices in ascending order, each once. `scratch`
/// has one value per cell of the grid, all 0, and is so again afterwards. O(cells).
[[nodiscard]] std::vector<CellBox> merge_boxes(const VoxelGrid& grid, const std::vector<int>& cells,
                                               std::vector<unsigned char>& scratch);

/// The grid with edges twice as long, from the same corner.
[[nodiscard]] VoxelGrid coarser(const VoxelGrid& grid);
/// The cells of coarser(grid) that hold any of `cells`, ascending, each once.
[[nodiscard]] std::vector<int> coarser_cells(const VoxelGrid& grid, const std::vector<int>& cells);

}  // namespace extperfc::arm
