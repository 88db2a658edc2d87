// The map's layer: values, rotation, other resolutions, updates.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/static_layer.hpp"

namespace extperfc::navigate {
namespace {

using Eigen::Vector2d;

OccupancyGrid map_of(std::size_t width, std::size_t height, std::int8_t value) {
  OccupancyGrid map;
  map.width = width;
  map.height = height;
  map.cells.assign(width * height, value);
  return map;
}

OccupancyGrid random_map(Rng& rng) {
  OccupancyGrid map = map_of(30, 20, 0);
  for (auto& cell : map.cells)
    cell = rng.chance(0.05)  ? OccupancyGrid::kOccupied
           : rng.chance(0.1) ? OccupancyGrid::kUnknown
                             : OccupancyGrid::kFree;
  return map;
}

CostGrid drawn(const OccupancyGrid& map, CostGrid grid, const StaticParams& params = {},
               const Pose2& pose = {}) {
  StaticLayer layer(params);
  layer.match(grid);
  EXPECT_TRUE(layer.set_map(map, pose));
  layer.write(grid, grid.box());
  return grid;
}

TEST(StaticLayer, ValuesBecomeCosts) {
  OccupancyGrid map = map_of(6, 1, 0);
  map.cells = {0, -1, 64, 65, 100, 30};
  const CostGrid grid = make_cost_grid(6, 1, 0.05, {0, 0}, kFreeCost);
  EXPECT_EQ(drawn(map, grid).cells, (std::vector<Cost>{0, 255, 0, 254, 254, 0}));
  EXPECT_EQ(drawn(map, grid, {65, false, true}).cells, (std::vector<Cost>{0, 0, 248, 254, 254, 116}));
  EXPECT_EQ(drawn(map, grid, {100, false, false}).cells, (std::vector<Cost>{0, 255, 161, 163, 254, 75}));
}

TEST(StaticLayer, OutsideTheMapIsNotWritten) {
  OccupancyGrid map = map_of(2, 2, 0);
  map.origin = {0.05, 0.05, 0};
  const CostGrid grid = drawn(map, make_cost_grid(4, 4, 0.05, {0, 0}, 7));
  EXPECT_EQ(grid.cells, (std::vector<Cost>{7, 7, 7, 7, 7, 0, 0, 7, 7, 0, 0, 7, 7, 7, 7, 7}));
}

TEST(StaticLayer, RotatedByRightAnglesIsExact) {
  Rng rng(1);
  for (int quarter = -2; quarter <= 2; ++quarter) {
    OccupancyGrid map = random_map(rng);
    map.origin = {1, 2, quarter * kPi / 2};
    const CostGrid grid = drawn(map, grid_around(map, 7));
    EXPECT_EQ(grid.width, quarter % 2 == 0 ? 30 : 20);
    for (std::size_t row = 0; row < map.height; ++row)
      for (std::size_t column = 0; column < map.width; ++column) {
        const Pose2 middle = map.middle_of({column, row});
        const auto cell = grid.cell_of({middle.x, middle.y});
        ASSERT_TRUE(cell);
        const std::int8_t value = map.at(column, row);
        EXPECT_EQ(grid.at(*cell), value < 0 ? kUnknownCost : value > 0 ? kLethalCost : kFreeCost);
      }
  }
}

TEST(StaticLayer, AnyRotationAndResolutionLosesNoObstacle) {
  Rng rng(2);
  for (int round = 0; round < 100; ++round) {
    OccupancyGrid map = random_map(rng);
    map.origin = {rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-kPi, kPi)};
    const Pose2 pose{rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-kPi, kPi)};
    const double resolution_m = rng.uniform(0.02, 0.15);
    const CostGrid grid = drawn(
        map, make_cost_grid(200, 200, resolution_m, {-100 * resolution_m, -100 * resolution_m}, 7), {}, pose);
    OccupancyGrid placed = map;
    placed.origin = compose(pose, map.origin);
    int lethal = 0;
    for (std::size_t row = 0; row < map.height; ++row)
      for (std::size_t column = 0; column < map.width; ++column) {
        const Pose2 middle = placed.middle_of({column, row});
        const auto cell = grid.cell_of({middle.x, middle.y});
        if (!cell) continue;
        EXPECT_NE(grid.at(*cell), 7);
        if (map.at(column, row) != OccupancyGrid::kOccupied) continue;
        ++lethal;
        EXPECT_EQ(grid.at(*cell), kLethalCost) << "round " << round;
      }
    // And none is invented: a lethal cell has an occupied one within half of both diagonals.
    for (int row = 0; row < grid.height; ++row)
      for (int column = 0; column < grid.width; ++column) {
        if (grid.at({column, row}) != kLethalCost) continue;
        bool near = false;
        const Vector2d middle = grid.middle_of({column, row});
        for (std::size_t i = 0; i < map.cells.size() && !near; ++i) {
          if (map.cells[i] != OccupancyGrid::kOccupied) continue;
          const Pose2 other = placed.middle_of({i % map.width, i / map.width});
          near = std::hypot(other.x - middle.x(), other.y - middle.y()) <=
                 std::sqrt(0.5) * std::max(resolution_m, map.resolution_m) + 1e-9;
        }
        EXPECT_TRUE(near) << "round " << round;
      }
    (void)lethal;
  }
}

TEST(StaticLayer, UpdatesOfARectangleAreTheSameAsANewMap) {
  Rng rng(3);
  for (const double yaw : {0.0, 0.3}) {
    OccupancyGrid map = random_map(rng);
    map.origin.yaw = yaw;
    const CostGrid empty = make_cost_grid(50, 50, 0.05, {-0.5, -0.5}, kFreeCost);
    StaticLayer layer;
    layer.match(empty);
    ASSERT_TRUE(layer.set_map(map));
    CostGrid grid = empty;
    layer.write(grid, grid.box());
    (void)layer.take_changes(grid, 0);
    for (int round = 0; round < 200; ++round) {
      const int column = rng.integer(0, 25), row = rng.integer(0, 15), width = rng.integer(1, 5),
                height = rng.integer(1, 5);
      std::vector<std::int8_t> cells;
      for (int i = 0; i < width * height; ++i)
        cells.push_back(static_cast<std::int8_t>(rng.integer(-1, 100)));
      for (int i = 0; i < width * height; ++i)
        map.cells[static_cast<std::size_t>((row + i / width) * 30 + column + i % width)] =
            cells[static_cast<std::size_t>(i)];
      ASSERT_TRUE(layer.update_map({{column, row}, {column + width, row + height}}, cells));
      layer.write(grid, layer.take_changes(grid, 0));
      ASSERT_EQ(grid.cells == drawn(map, empty).cells, true) << "round " << round << ", yaw " << yaw;
    }
  }
}

TEST(StaticLayer, RefusesDamagedMapsAndUpdates) {
  StaticLayer layer;
  layer.match(make_cost_grid(10, 10, 0.05, {0, 0}, kFreeCost));
  EXPECT_FALSE(layer.update_map({{0, 0}, {1, 1}}, {0}));  // no map yet
  EXPECT_FALSE(layer.set_map({}));
  OccupancyGrid map = map_of(5, 5, 0);
  map.cells.pop_back();
  EXPECT_FALSE(layer.set_map(map));
  map = map_of(5, 5, 0);
  map.resolution_m = 0;
  EXPECT_FALSE(layer.set_map(map));
  map = map_of(5, 5, 0);
  map.origin.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(layer.set_map(map));
  EXPECT_FALSE(layer.set_map(map_of(5, 5, 0), map.origin));
  ASSERT_TRUE(layer.set_map(map_of(5, 5, 0)));
  EXPECT_FALSE(layer.update_map({{4, 4}, {6, 5}}, {0, 0}));
  EXPECT_FALSE(layer.update_map({{-1, 0}, {1, 1}}, {0, 0}));
  EXPECT_FALSE(layer.update_map({{0, 0}, {2, 1}}, {0}));
  EXPECT_FALSE(layer.update_map({{0, 0}, {0, 1}}, {}));
  EXPECT_TRUE(layer.update_map({{4, 4}, {5, 5}}, {0}));
  EXPECT_THROW(StaticLayer({0, true, false}), std::invalid_argument);
}

TEST(StaticLayer, GridAroundHoldsARotatedMap) {
  OccupancyGrid map = map_of(30, 20, 0);
  map.origin = {1, 2, 0.4};
  const CostGrid grid = grid_around(map, kUnknownCost);
  for (const std::size_t column : {0, 29})
    for (const std::size_t row : {0, 19}) {
      const Pose2 middle = map.middle_of({column, row});
      EXPECT_TRUE(grid.cell_of({middle.x, middle.y}));
    }
  EXPECT_THROW((void)grid_around({}, kFreeCost), std::invalid_argument);
}

}  // namespace
}  // namespace extperfc::navigate
