// The direction in which a narrow place is widest.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"

#include "navigate/global/passage_line.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kDegree = kPi / 180;

const BlockedCosts kLethal = [](Cost cost) { return cost == kLethalCost; };

/// Floor of 6 x 6 m about the origin, in cells of 2.5 cm.
CostGrid floor_grid() {
  return make_cost_grid(240, 240, 0.025, {-3, -3}, kFreeCost);
}

void block(CostGrid& grid, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const int steps = static_cast<int>((to - from).norm() / 0.01);
  for (int k = 0; k <= steps; ++k)
    grid.at(grid.cell_around(from + (to - from) * k / std::max(1, steps))) = kLethalCost;
}

/// A wall along y with a door of 0.96 m.
CostGrid wall_with_door() {
  CostGrid grid = floor_grid();
  block(grid, {0, -3}, {0, -0.48});
  block(grid, {0, 0.48}, {0, 2.9});
  return grid;
}

/// The same with a leaf that stands open by `open_deg` towards +x, its hinge at +y.
CostGrid door(double open_deg) {
  CostGrid grid = wall_with_door();
  const double angle = -90 * kDegree + open_deg * kDegree;  // of the leaf; 0: along x
  block(grid, {0, 0.48}, {0.9 * std::cos(angle), 0.48 + 0.9 * std::sin(angle)});
  return grid;
}

TEST(WidestLine, GoesAlongADoorsLeaf) {
  for (const double open_deg : {75.0, 80.0, 85.0}) {
    SCOPED_TRACE(open_deg);
    const Pose2 line = widest_line(door(open_deg), kLethal, {0.1, 0, 0}, 0.8);
    EXPECT_NEAR(line.yaw, (open_deg - 90) * kDegree, 3 * kDegree);
    // Between the leaf's hinge and the other jamb, where the line crosses the wall.
    EXPECT_NEAR(line.y - line.x * std::tan(line.yaw), 0, 0.03);
  }
}

TEST(WidestLine, StaysStraightInADoorWithoutALeaf) {
  const Pose2 line = widest_line(wall_with_door(), kLethal, {0.1, 0.2, 0}, 0.8);
  EXPECT_NEAR(line.yaw, 0, 2 * kDegree);
  EXPECT_NEAR(line.y, 0, 0.03) << "in its middle";
}

TEST(WidestLine, WhereNothingStandsThePoseIsKept) {
  const Pose2 line = widest_line(floor_grid(), kLethal, {0.3, 0.2, 0.5}, 0.8);
  EXPECT_NEAR(line.x, 0.3, 1e-9);
  EXPECT_NEAR(line.y, 0.2, 1e-9);
  EXPECT_NEAR(line.yaw, 0.5, 1e-9);
}

TEST(WidestLine, UnknownCellsCountAsTheCallerSays) {
  CostGrid grid = door(80);
  for (Cost& cost : grid.cells)
    if (cost == kLethalCost) cost = kUnknownCost;
  EXPECT_NEAR(widest_line(grid, kLethal, {0.1, 0, 0}, 0.8).yaw, 0, 1e-9);
  const auto unknown_too = [](Cost cost) { return cost == kUnknownCost; };
  EXPECT_NEAR(widest_line(grid, unknown_too, {0.1, 0, 0}, 0.8).yaw, -10 * kDegree, 3 * kDegree);
}

}  // namespace

}  // namespace extperfc::navigate
