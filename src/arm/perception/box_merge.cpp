#include "arm/perception/box_merge.hpp"

#include <algorithm>

namespace extperfc::arm {
namespace {

constexpr unsigned char kThere = 1;

class Merger {
 public:
  Merger(const VoxelGrid& grid, std::vector<unsigned char>& there) : grid_(grid), there_(there) {}

  /// From a cell that is there.
  CellBox grow(const Eigen::Vector3i& first) {
    CellBox box{first, first};
    for (int axis = 0; axis < 3; ++axis)
      while (box.last[axis] + 1 < grid_.count[axis] && next_layer_there(box, axis)) ++box.last[axis];
    take(box);
    return box;
  }

 private:
  [[nodiscard]] bool next_layer_there(const CellBox& box, int axis) const {
    CellBox layer = box;
    layer.first[axis] = layer.last[axis] = box.last[axis] + 1;
    for (int z = layer.first.z(); z <= layer.last.z(); ++z)
      for (int y = layer.first.y(); y <= layer.last.y(); ++y)
        for (int x = layer.first.x(); x <= layer.last.x(); ++x)
          if (there_[grid_.index(x, y, z)] != kThere) return false;
    return true;
  }

  void take(const CellBox& box) {
    for (int z = box.first.z(); z <= box.last.z(); ++z)
      for (int y = box.first.y(); y <= box.last.y(); ++y)
        for (int x = box.first.x(); x <= box.last.x(); ++x) there_[grid_.index(x, y, z)] = 0;
  }

  const VoxelGrid& grid_;
  std::vector<unsigned char>& there_;
};

}  // namespace

std::vector<CellBox> merge_boxes(const VoxelGrid& grid, const std::vector<int>& cells,
                                 std::vector<unsigned char>& scratch) {
  for (const int cell : cells) scratch[cell] = kThere;
  std::vector<CellBox> boxes;
  Merger merger(grid, scratch);
  for (const int cell : cells)
    if (scratch[cell] == kThere) boxes.push_back(merger.grow(grid.cell(cell)));
  return boxes;
}

VoxelGrid coarser(const VoxelGrid& grid) {
  return {grid.low, 2 * grid.edge, (grid.count.array() + 1) / 2};
}

std::vector<int> coarser_cells(const VoxelGrid& grid, const std::vector<int>& cells) {
  const VoxelGrid wide = coarser(grid);
  std::vector<int> result;
  result.reserve(cells.size());
  for (const int cell : cells) {
    const Eigen::Vector3i at = grid.cell(cell) / 2;
    result.push_back(wide.index(at.x(), at.y(), at.z()));
  }
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

}  // namespace extperfc::arm
