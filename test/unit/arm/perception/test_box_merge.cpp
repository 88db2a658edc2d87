// Boxes made of voxels.
#include <algorithm>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "arm/perception/box_merge.hpp"

namespace extperfc::arm {
namespace {

const VoxelGrid kGrid{{0, 0, 0}, 0.02, {9, 7, 5}};

std::vector<int> random_cells(Rng& rng, double fraction) {
  std::vector<int> cells;
  for (int i = 0; i < static_cast<int>(kGrid.size()); ++i)
    if (rng.chance(fraction)) cells.push_back(i);
  return cells;
}

TEST(BoxMerge, EveryCellIsInOneBoxAndNothingElseIs) {
  Rng rng(1);
  std::vector<unsigned char> scratch(kGrid.size(), 0);
  for (const double fraction : {0.05, 0.5, 0.95, 1.0}) {
    const std::vector<int> cells = random_cells(rng, fraction);
    std::vector<int> covered;
    for (const CellBox& box : merge_boxes(kGrid, cells, scratch))
      for (int z = box.first.z(); z <= box.last.z(); ++z)
        for (int y = box.first.y(); y <= box.last.y(); ++y)
          for (int x = box.first.x(); x <= box.last.x(); ++x) covered.push_back(kGrid.index(x, y, z));
    std::sort(covered.begin(), covered.end());
    EXPECT_EQ(covered, cells);
    EXPECT_EQ(std::count(scratch.begin(), scratch.end(), 0), static_cast<std::ptrdiff_t>(scratch.size()));
  }
}

TEST(BoxMerge, AFullBlockIsOneBox) {
  std::vector<unsigned char> scratch(kGrid.size(), 0);
  Rng rng(1);
  EXPECT_EQ(merge_boxes(kGrid, random_cells(rng, 1.1), scratch).size(), 1U);
  EXPECT_TRUE(merge_boxes(kGrid, {}, scratch).empty());
}

TEST(BoxMerge, CoarserCellsHoldTheFineOnes) {
  Rng rng(2);
  const std::vector<int> cells = random_cells(rng, 0.1);
  const VoxelGrid wide = coarser(kGrid);
  const std::vector<int> wide_cells = coarser_cells(kGrid, cells);
  EXPECT_TRUE(std::is_sorted(wide_cells.begin(), wide_cells.end()));
  std::vector<bool> used(wide.size(), false);
  for (const int cell : cells) {
    const Eigen::Vector3i at = kGrid.cell(cell);
    const auto found = std::find_if(wide_cells.begin(), wide_cells.end(), [&](int other) {
      return ((kGrid.centre(at) - wide.centre(wide.cell(other))).cwiseAbs().array() < wide.edge / 2).all();
    });
    ASSERT_NE(found, wide_cells.end());
    used[*found] = true;
  }
  for (const int cell : wide_cells) EXPECT_TRUE(used[cell]);
}

}  // namespace
}  // namespace extperfc::arm
