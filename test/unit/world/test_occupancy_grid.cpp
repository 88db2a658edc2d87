#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/world/occupancy_grid.hpp"

namespace extperfc {
namespace {

OccupancyGrid grid(std::size_t width, std::size_t height, double resolution_m, const Pose2& origin) {
  return {width, height, resolution_m, origin,
          std::vector<std::int8_t>(width * height, OccupancyGrid::kUnknown)};
}

TEST(OccupancyGrid, CellsAreCountedFromTheLowerLeft) {
  OccupancyGrid map = grid(3, 2, 0.5, {10, 20, 0});
  map.cells[1 * 3 + 2] = 70;
  EXPECT_EQ(map.at(2, 1), 70);
  const auto cell = map.cell_of(11.2, 20.6);
  ASSERT_TRUE(cell);
  EXPECT_EQ(cell->column, 2U);
  EXPECT_EQ(cell->row, 1U);
  const Pose2 middle = map.middle_of({2, 1});
  EXPECT_DOUBLE_EQ(middle.x, 11.25);
  EXPECT_DOUBLE_EQ(middle.y, 20.75);
}

TEST(OccupancyGrid, EdgesBelongToOneCell) {
  const OccupancyGrid map = grid(4, 4, 1, {});
  EXPECT_EQ(map.cell_of(0, 0)->column, 0U);
  EXPECT_EQ(map.cell_of(1, 0)->column, 1U);
  EXPECT_EQ(map.cell_of(3.999, 3.999)->row, 3U);
  EXPECT_FALSE(map.cell_of(4, 0));
  EXPECT_FALSE(map.cell_of(0, 4));
  EXPECT_FALSE(map.cell_of(-1e-9, 0));
}

TEST(OccupancyGrid, NowhereIsOutside) {
  const OccupancyGrid map = grid(4, 4, 1, {});
  EXPECT_FALSE(map.cell_of(std::nan(""), 1));
  EXPECT_FALSE(map.cell_of(1, std::nan("")));
  EXPECT_FALSE(map.cell_of(HUGE_VAL, 1));
  EXPECT_FALSE(map.cell_of(1, -HUGE_VAL));
  EXPECT_FALSE(map.cell_of(1e300, 1));
  EXPECT_FALSE(OccupancyGrid().cell_of(0, 0));
  EXPECT_TRUE(OccupancyGrid().empty());
}

TEST(OccupancyGrid, TheMiddleOfACellLiesInIt) {
  Rng rng(3);
  for (int i = 0; i < 500; ++i) {
    const OccupancyGrid map =
        grid(static_cast<std::size_t>(rng.integer(1, 60)), static_cast<std::size_t>(rng.integer(1, 60)),
             rng.uniform(0.01, 1), {rng.uniform(-90, 90), rng.uniform(-90, 90), rng.uniform(-4, 4)});
    const OccupancyGrid::Cell cell{
        static_cast<std::size_t>(rng.integer(0, static_cast<int>(map.width) - 1)),
        static_cast<std::size_t>(rng.integer(0, static_cast<int>(map.height) - 1))};
    const Pose2 middle = map.middle_of(cell);
    const auto found = map.cell_of(middle.x, middle.y);
    ASSERT_TRUE(found) << "trial " << i;
    EXPECT_EQ(found->column, cell.column);
    EXPECT_EQ(found->row, cell.row);
    EXPECT_NEAR(wrap_angle(middle.yaw - map.origin.yaw), 0, 1e-9);
  }
}

}  // namespace
}  // namespace extperfc
