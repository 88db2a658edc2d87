// Inflation: costmap_2d's costs by exact distances.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/inflation_layer.hpp"

namespace extperfc::navigate {
namespace {

/// Around every lethal cell, one after the other.
CostGrid inflated(const CostGrid& grid, const Inflation& inflation) {
  CostGrid result = grid;
  for (int row = 0; row < grid.height; ++row)
    for (int column = 0; column < grid.width; ++column)
      for (int r = 0; r < grid.height; ++r)
        for (int c = 0; c < grid.width; ++c) {
          Cost& cost = result.at({column, row});
          if (grid.at({c, r}) != kLethalCost || cost == kUnknownCost) continue;
          const double distance_m =
              std::sqrt((column - c) * (column - c) + (row - r) * (row - r)) * grid.resolution_m;
          cost = std::max(cost, inflation.cost_at(distance_m));
        }
  return result;
}

CostGrid random_grid(Rng& rng) {
  CostGrid grid = make_cost_grid(rng.integer(1, 40), rng.integer(1, 40), 0.05, {0, 0}, kFreeCost);
  const double density = rng.chance(0.5) ? 0.003 : 0.1;
  for (Cost& cost : grid.cells)
    cost = rng.chance(density) ? kLethalCost
           : rng.chance(0.1)   ? kUnknownCost
                               : static_cast<Cost>(rng.integer(0, 9));
  return grid;
}

TEST(InflationLayer, CostsOfDistances) {
  const Inflation inflation{0.3, 0.55, 5};
  EXPECT_EQ(inflation.cost_at(0), kLethalCost);
  EXPECT_EQ(inflation.cost_at(0.05), kInscribedCost);
  EXPECT_EQ(inflation.cost_at(6 * 0.05), kInscribedCost);
  EXPECT_EQ(inflation.cost_at(0.35), static_cast<Cost>(252 * std::exp(-0.25)));
  EXPECT_EQ(inflation.cost_at(11 * 0.05), static_cast<Cost>(252 * std::exp(-1.25)));
  EXPECT_EQ(inflation.cost_at(0.56), kFreeCost);
}

TEST(InflationLayer, IsExact) {
  Rng rng(1);
  for (int round = 0; round < 200; ++round) {
    CostGrid grid = random_grid(rng);
    const double radius_m = rng.uniform(0, 1.2);
    const Inflation inflation{rng.uniform(0, radius_m), radius_m, rng.uniform(0, 10)};
    const CostGrid expected = inflated(grid, inflation);
    InflationLayer layer(inflation);
    layer.match(grid);
    EXPECT_EQ(layer.take_changes(grid, 0).max.column, grid.width);
    layer.write(grid, grid.box());
    ASSERT_EQ(grid.cells == expected.cells, true) << "round " << round;
  }
}

TEST(InflationLayer, WritesInsideTheBoxOnly) {
  Rng rng(2);
  for (int round = 0; round < 200; ++round) {
    const CostGrid before = random_grid(rng);
    const Inflation inflation{0.2, 0.5, 3};
    const CostGrid expected = inflated(before, inflation);
    CostGrid grid = before;
    InflationLayer layer(inflation);
    layer.match(grid);
    layer.write(grid, grid.box());
    const CellBox box{{rng.integer(0, grid.width - 1), rng.integer(0, grid.height - 1)},
                      {grid.width, grid.height}};
    // The layers before write the box anew; the cells outside hold other costs than before.
    grid.cells.assign(grid.cells.size(), 99);
    for (int row = box.min.row; row < box.max.row; ++row)
      for (int column = box.min.column; column < box.max.column; ++column)
        grid.at({column, row}) = before.at({column, row});
    layer.write(grid, box);
    for (int row = 0; row < grid.height; ++row)
      for (int column = 0; column < grid.width; ++column)
        ASSERT_EQ(grid.at({column, row}),
                  column >= box.min.column && row >= box.min.row ? expected.at({column, row}) : 99)
            << "round " << round;
  }
}

TEST(InflationLayer, RefusesWhatCannotBe) {
  EXPECT_THROW(InflationLayer({-0.1, 1, 1}), std::invalid_argument);
  EXPECT_THROW(InflationLayer({0.6, 0.5, 1}), std::invalid_argument);
  EXPECT_THROW(InflationLayer({0.6, 11, 1}), std::invalid_argument);
  EXPECT_THROW(InflationLayer({0.6, 1, -1}), std::invalid_argument);
  EXPECT_THROW(InflationLayer({0.6, std::nan(""), 1}), std::invalid_argument);
}

}  // namespace
}  // namespace extperfc::navigate
