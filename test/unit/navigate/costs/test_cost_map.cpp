// Cost maps: what is brought up to date is the same as what is made anew, for less work.
#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/inflation_layer.hpp"
#include "extperfc/navigate/obstacle_layer.hpp"
#include "extperfc/navigate/static_layer.hpp"
#include "extperfc/navigate/zone_layer.hpp"

namespace extperfc::navigate {
namespace {

using Eigen::Vector2d;

/// A cost map and its layers.
struct Stack {
  explicit Stack(const CostGrid& grid, bool zones_last = false) : map(grid) {
    map.add(fixed);
    map.add(obstacles);
    if (!zones_last) map.add(zones);
    map.add(inflation);
    if (zones_last) map.add(zones);
  }
  std::shared_ptr<StaticLayer> fixed = std::make_shared<StaticLayer>();
  std::shared_ptr<ObstacleLayer> obstacles =
      std::make_shared<ObstacleLayer>(ObstacleParams{0, 1, 5, 0.1, true});
  std::shared_ptr<ZoneLayer> zones = std::make_shared<ZoneLayer>();
  std::shared_ptr<InflationLayer> inflation = std::make_shared<InflationLayer>(Inflation{0.25, 0.6, 4});
  CostMap map;
};

OccupancyGrid random_map(Rng& rng, std::size_t width, std::size_t height) {
  OccupancyGrid map;
  map.width = width;
  map.height = height;
  map.resolution_m = 0.1;
  map.origin = {-1, -2, 0};
  for (std::size_t i = 0; i < width * height; ++i)
    map.cells.push_back(rng.chance(0.02)  ? OccupancyGrid::kOccupied
                        : rng.chance(0.1) ? OccupancyGrid::kUnknown
                                          : OccupancyGrid::kFree);
  return map;
}

LaserScan random_scan(Rng& rng, double stamp_s) {
  LaserScan scan;
  scan.stamp_s = stamp_s;
  scan.angle_min = -1.5;
  scan.angle_increment = 0.05;
  scan.range_min = 0.1;
  scan.range_max = 4;
  for (int i = 0; i < 60; ++i)
    scan.ranges.push_back(rng.chance(0.1)   ? std::numeric_limits<float>::quiet_NaN()
                          : rng.chance(0.1) ? std::numeric_limits<float>::infinity()
                                            : static_cast<float>(rng.uniform(0.2, 4)));
  return scan;
}

using Change = std::function<void(Stack&)>;

Change random_update(Rng& rng) {
  const int column = rng.integer(0, 40), row = rng.integer(0, 30);
  const int width = rng.integer(1, 8), height = rng.integer(1, 8);
  std::vector<std::int8_t> cells;
  for (int i = 0; i < width * height; ++i)
    cells.push_back(static_cast<std::int8_t>(std::vector<int>{0, 0, 0, -1, 100}[rng.integer(0, 4)]));
  return [=](Stack& stack) {
    EXPECT_TRUE(stack.fixed->update_map({{column, row}, {column + width, row + height}}, cells));
  };
}

Change random_change(Rng& rng, double now_s) {
  switch (rng.integer(0, 11)) {
    case 0:
    case 1:
    case 2:
      return random_update(rng);
    case 3: {
      const double x = rng.uniform(-2, 5), y = rng.uniform(-2, 3);
      return [=](Stack& stack) {
        stack.zones->set_zones({{{"zone", {{x, y}, {x + 0.5, y + 0.1}, {x + 0.2, y + 0.7}}}}, {}, {}});
      };
    }
    case 4: {
      const Pose2 pose{rng.uniform(-1, 5), rng.uniform(-2, 3), rng.uniform(-kPi, kPi)};
      return [=](Stack& stack) { stack.obstacles->clear_footprint(Footprint::circle(0.4), pose); };
    }
    case 5: {
      const double radius_m = rng.uniform(0.3, 0.9);
      return [=](Stack& stack) { stack.inflation->set({0.25, radius_m, 4}); };
    }
    default: {
      const LaserScan scan = random_scan(rng, now_s);
      const Pose2 pose{rng.uniform(-1, 5), rng.uniform(-2, 3), rng.uniform(-kPi, kPi)};
      return [=](Stack& stack) { EXPECT_TRUE(stack.obstacles->observe(scan, pose, 0.2, {})); };
    }
  }
}

void expect_same(const Stack& a, const Stack& b, int round) {
  ASSERT_EQ(a.map.grid().cells == b.map.grid().cells, true) << "round " << round;
  EXPECT_EQ(a.map.grid().may_hold_unknown, b.map.grid().may_hold_unknown);
  EXPECT_EQ(a.map.grid().inflation.radius_m, b.map.grid().inflation.radius_m);
}

/// The same changes to two stacks, of which one is made anew each time.
void run(std::uint64_t seed, bool rolling, bool zones_last) {
  Rng rng(seed);
  const CostGrid grid = make_cost_grid(60, 45, 0.1, {-1.5, -2.3}, zones_last ? kUnknownCost : kFreeCost);
  Stack lazy(grid, zones_last), full(grid, zones_last);
  const OccupancyGrid floor = random_map(rng, 50, 40);
  for (Stack* stack : {&lazy, &full}) ASSERT_TRUE(stack->fixed->set_map(floor));
  double now_s = 100;
  for (int round = 0; round < 1500; ++round) {
    now_s += rng.uniform(0, 0.3);
    for (int i = rng.integer(0, 3); i > 0; --i) {
      const Change change = random_change(rng, now_s);
      for (Stack* stack : {&lazy, &full}) change(*stack);
    }
    if (rolling && rng.chance(0.3)) {
      const Vector2d centre(rng.uniform(-1, 4), rng.uniform(-2, 2));
      for (Stack* stack : {&lazy, &full}) stack->map.centre_on(centre);
    }
    CostGrid same = full.map.grid();
    std::fill(same.cells.begin(), same.cells.end(), grid.cells.front());
    full.map.resize(same);
    (void)lazy.map.update(now_s);
    (void)full.map.update(now_s);
    ASSERT_NO_FATAL_FAILURE(expect_same(lazy, full, round)) << "seed " << seed;
  }
  EXPECT_LT(lazy.map.cells_written(), full.map.cells_written());
}

TEST(CostMap, IncrementalIsTheSameAsFull) {
  run(1, false, false);
  run(2, false, true);
}

TEST(CostMap, IncrementalIsTheSameAsFullWhileRolling) {
  run(3, true, false);
  run(4, true, true);
}

TEST(CostMap, ReturnedBoxHoldsEveryChange) {
  Rng rng(5);
  Stack stack(make_cost_grid(60, 45, 0.1, {-1.5, -2.3}, kFreeCost));
  ASSERT_TRUE(stack.fixed->set_map(random_map(rng, 50, 40)));
  (void)stack.map.update(0);
  for (int round = 0; round < 500; ++round) {
    const CostGrid before = stack.map.grid();
    random_change(rng, round)(stack);
    const CellBox box = stack.map.update(round);
    for (int row = 0; row < before.height; ++row)
      for (int column = 0; column < before.width; ++column)
        if (before.at({column, row}) != stack.map.grid().at({column, row})) {
          ASSERT_TRUE(column >= box.min.column && column < box.max.column && row >= box.min.row &&
                      row < box.max.row);
        }
  }
}

TEST(CostMap, WorkGrowsWithTheChange) {
  Stack stack(make_cost_grid(1000, 1000, 0.05, {0, 0}, kFreeCost));
  OccupancyGrid floor;
  floor.width = floor.height = 1000;
  floor.cells.assign(1000000, 0);
  ASSERT_TRUE(stack.fixed->set_map(floor));
  (void)stack.map.update(0);
  EXPECT_EQ(stack.map.cells_written(), 1000000U);
  (void)stack.map.update(0.1);
  EXPECT_EQ(stack.map.cells_written(), 1000000U);
  ASSERT_TRUE(stack.fixed->update_map({{500, 500}, {501, 501}}, {100}));
  (void)stack.map.update(0.2);
  EXPECT_LE(stack.map.cells_written() - 1000000U, 30U * 30U);  // 0.6 m about one cell, and what may round
  LaserScan scan;
  scan.stamp_s = 0.3;
  scan.angle_increment = 0.01;
  scan.range_max = 10;
  scan.ranges.assign(20, 2.0F);
  ASSERT_TRUE(stack.obstacles->observe(scan, {25, 25, 0}, 0.2, {}));
  const std::size_t before = stack.map.cells_written();
  (void)stack.map.update(0.3);
  EXPECT_LE(stack.map.cells_written() - before, 50U * 100U);
}

TEST(CostMap, RollingMovesByWholeCells) {
  CostMap map(make_cost_grid(40, 40, 0.1, {0.05, 0}, kUnknownCost));
  map.centre_on({10.02, -3.33});
  const Vector2d moved = (map.grid().origin_m - Vector2d(0.05, 0)) / 0.1;
  EXPECT_NEAR(moved.x(), std::round(moved.x()), 1e-9);
  EXPECT_NEAR(moved.y(), std::round(moved.y()), 1e-9);
  EXPECT_LE(std::abs(map.grid().origin_m.x() + 2 - 10.02), 0.05 + 1e-9);
  EXPECT_LE(std::abs(map.grid().origin_m.y() + 2 + 3.33), 0.05 + 1e-9);
  const Vector2d before = map.grid().origin_m;
  map.centre_on({std::numeric_limits<double>::quiet_NaN(), 0});
  map.centre_on({1e300, 0});
  EXPECT_EQ(map.grid().origin_m, before);
}

TEST(CostMap, RollingKeepsObstaclesThatStay) {
  Stack stack(make_cost_grid(40, 40, 0.1, {0, 0}, kFreeCost));
  LaserScan scan;
  scan.angle_increment = 1;
  scan.range_max = 10;
  scan.ranges = {1.0F};
  ASSERT_TRUE(stack.obstacles->observe(scan, {2.05, 2.05, 0}, 0.2, {}));
  for (int i = 0; i < 20; ++i) {
    stack.map.centre_on({2 + 0.1 * i, 2 - 0.05 * i});
    (void)stack.map.update(0);
    const auto cell = stack.map.grid().cell_of({3.05, 2.05});
    ASSERT_TRUE(cell);
    EXPECT_EQ(stack.map.grid().at(*cell), kLethalCost) << i;
  }
  stack.map.centre_on({20, 20});
  stack.map.centre_on({2, 2});
  (void)stack.map.update(0);
  EXPECT_EQ(stack.obstacles->marked_cells(), 0U);
}

TEST(CostMap, KnowsWhetherACellIsUnknown) {
  Stack stack(make_cost_grid(10, 10, 0.1, {0, 0}, kFreeCost));
  OccupancyGrid map;
  map.width = map.height = 10;
  map.resolution_m = 0.1;
  map.cells.assign(100, 0);
  map.cells[55] = -1;
  EXPECT_FALSE(stack.map.grid().may_hold_unknown);
  ASSERT_TRUE(stack.fixed->set_map(map));
  (void)stack.map.update(0);
  EXPECT_TRUE(stack.map.grid().may_hold_unknown);
  ASSERT_TRUE(stack.fixed->update_map({{5, 5}, {6, 6}}, {0}));
  (void)stack.map.update(0);
  EXPECT_FALSE(stack.map.grid().may_hold_unknown);
}

TEST(CostMap, ClearForgetsSensorsAndKeepsTheMap) {
  Rng rng(6);
  Stack stack(make_cost_grid(60, 45, 0.1, {-1.5, -2.3}, kFreeCost));
  ASSERT_TRUE(stack.fixed->set_map(random_map(rng, 50, 40)));
  (void)stack.map.update(0);
  const CostGrid before = stack.map.grid();
  ASSERT_TRUE(stack.obstacles->observe(random_scan(rng, 1), {2, 0, 0}, 0.2, {}));
  (void)stack.map.update(1);
  EXPECT_NE(before.cells, stack.map.grid().cells);
  stack.map.clear();
  (void)stack.map.update(1);
  EXPECT_EQ(before.cells, stack.map.grid().cells);
}

TEST(CostMap, RefusesWhatCannotBe) {
  EXPECT_THROW(CostMap{CostGrid{}}, std::invalid_argument);
  CostMap map(make_cost_grid(2, 2, 0.1, {0, 0}, kFreeCost));
  EXPECT_THROW(map.add(nullptr), std::invalid_argument);
}

}  // namespace
}  // namespace extperfc::navigate
