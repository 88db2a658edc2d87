// Least path cost over cells beside a path over blocks.

#include <cmath>

#include <gtest/gtest.h>

#include "navigate/global/grid_search.hpp"

namespace extperfc::navigate {

namespace {

constexpr int kSide_cells = 100;

Traversal point_robot() {
  Traversal traversal;
  for (std::size_t cost = 0; cost < kInscribedCost; ++cost)
    traversal.weight[cost] = 1 + static_cast<float>(cost) / 50;
  return traversal;
}

/// A wall along a column of blocks with a door at rows 90 to 95. The block at row 40 has three free cells
/// that do not hang together; two of them look like a passage to the search over blocks.
CostGrid wall_that_looks_open() {
  CostGrid grid = make_cost_grid(kSide_cells, kSide_cells, 0.05, {0, 0}, kFreeCost);
  for (int row = 0; row < kSide_cells; ++row)
    for (int column = 40; column < 44; ++column)
      if (row < 90 || row > 95) grid.at({column, row}) = kLethalCost;
  for (const Cell& cell : {Cell{40, 40}, Cell{40, 42}, Cell{43, 42}}) grid.at(cell) = kFreeCost;
  return grid;
}

double length(const Polyline& path) {
  double sum = 0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += (path[i] - path[i - 1]).norm();
  return sum;
}

TEST(GridSearch, SearchesEverywhereWhereNoPathLiesBesideThatOverBlocks) {
  const CostGrid grid = wall_that_looks_open();
  const Traversal traversal = point_robot();
  const PlanClock clock(nullptr, 5);
  GridSearch search;
  ASSERT_EQ(search.find(grid, traversal, {20.5, 42.5}, {60.5, 42.5}, clock), GridSearch::Status::kFound);
  const double corner_to_corner = 2 * std::hypot(19.5, 47.5) + 4;  // through the door's nearest corner
  EXPECT_GE(length(search.path()), corner_to_corner - 2);
  EXPECT_LE(length(search.path()), 1.02 * corner_to_corner + 2);
}

}  // namespace

}  // namespace extperfc::navigate
