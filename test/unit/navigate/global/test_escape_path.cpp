// A base that touches a wall a little gets away from it, and only away.
#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/escape_path.hpp"

namespace extperfc::navigate {
namespace {

constexpr double kCell_m = 0.05;

/// A room of 4 x 4 m around the origin, with walls of one cell.
CostGrid room() {
  CostGrid grid = make_cost_grid(80, 80, kCell_m, {-2, -2}, kFreeCost);
  for (int i = 0; i < 80; ++i)
    for (const Cell cell : {Cell{i, 0}, Cell{i, 79}, Cell{0, i}, Cell{79, i}}) grid.at(cell) = kLethalCost;
  return grid;
}

Footprint base() {
  return *Footprint::make({{0.4, 0.3}, {-0.4, 0.3}, {-0.4, -0.3}, {0.4, -0.3}});
}

void expect_escape(const CostGrid& grid, const Pose2& start, BaseKind kind) {
  const auto path = escape_path(grid, base(), start, kind);
  ASSERT_TRUE(path) << start.x << " " << start.y << " " << start.yaw;
  EXPECT_EQ(contact(grid, base(), path->poses.back()), Contact::kFree);
  for (std::size_t i = 1; i < path->poses.size(); ++i) {
    const Pose2 step = between(path->poses[i - 1], path->poses[i]);
    EXPECT_LE(std::hypot(step.x, step.y), 0.0251);
    EXPECT_LE(std::abs(step.yaw), 0.0501);
    if (kind == BaseKind::kDifferential) {
      EXPECT_NEAR(step.y, 0, 1e-9) << "along the heading";
    }
  }
  EXPECT_LE(length_m(*path), 0.41);
}

TEST(EscapePath, AwayFromAWallInAnyDirection) {
  const CostGrid grid = room();
  Rng rng(1);
  int touched = 0;
  while (touched < 200) {
    const Pose2 start{rng.uniform(-1.7, 1.7), rng.uniform(-1.7, 1.7), rng.uniform(-M_PI, M_PI)};
    if (contact(grid, base(), start) == Contact::kFree) continue;
    if (contact(grid, base().padded(-0.1), start) != Contact::kFree) continue;
    ++touched;
    expect_escape(grid, start, BaseKind::kHolonomic);
  }
}

TEST(EscapePath, ADifferentialBaseDrivesBackFromAWallAheadOfIt) {
  expect_escape(room(), {1.6, 0, 0}, BaseKind::kDifferential);
}

TEST(EscapePath, NoneFromDeepInsideAnObstacleNorWhereNoPlaceIsFree) {
  CostGrid grid = room();
  EXPECT_FALSE(escape_path(grid, base(), {1.85, 0, 0}, BaseKind::kHolonomic));
  for (int row = 0; row < 80; ++row)  // a corridor that is a little too narrow
    for (int column = 0; column < 80; ++column)
      if (std::abs(column - 39.5) > 4.6) grid.at({column, row}) = kLethalCost;
  EXPECT_FALSE(escape_path(grid, base(), {0, 0, M_PI / 2}, BaseKind::kHolonomic));
}

}  // namespace
}  // namespace extperfc::navigate
