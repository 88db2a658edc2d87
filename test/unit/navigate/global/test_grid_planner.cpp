// Passages that the true footprint only passes by turning, alternatives, headings, inflated and bare maps.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/global_planner.hpp"

#include "test/unit/navigate/planned_path.hpp"

namespace extperfc::navigate {

namespace {

using contract::expect_drivable;

constexpr double kCell_m = 0.05;

/// A rectangular base with its origin in the middle.
Footprint rectangle(double length_m, double width_m) {
  const double x = 0.5 * length_m;
  const double y = 0.5 * width_m;
  auto made = Footprint::make({{x, y}, {-x, y}, {-x, -y}, {x, -y}});
  EXPECT_TRUE(made);
  return *made;
}

CostGrid floor_of(double width_m, double height_m) {
  return make_cost_grid(static_cast<int>(std::lround(width_m / kCell_m)),
                        static_cast<int>(std::lround(height_m / kCell_m)), kCell_m, {0, 0}, kFreeCost);
}

/// A lethal rectangle [m].
void block(CostGrid& grid, double left, double bottom, double right, double top) {
  for (int row = 0; row < grid.height; ++row)
    for (int column = 0; column < grid.width; ++column) {
      const Eigen::Vector2d middle = grid.middle_of({column, row});
      if (middle.x() > left && middle.x() < right && middle.y() > bottom && middle.y() < top)
        grid.at({column, row}) = kLethalCost;
    }
}

void inflate(CostGrid& grid, const Footprint& footprint) {
  grid.inflation = {footprint.inscribed_radius_m(), 0.9, 8};
  grid.may_hold_unknown = false;
  const CostGrid bare = grid;
  const int reach = static_cast<int>(0.9 / kCell_m);
  for (int row = 0; row < grid.height; ++row)
    for (int column = 0; column < grid.width; ++column) {
      if (bare.at({column, row}) != kLethalCost) continue;
      for (int r = std::max(0, row - reach); r <= std::min(grid.height - 1, row + reach); ++r)
        for (int c = std::max(0, column - reach); c <= std::min(grid.width - 1, column + reach); ++c) {
          const double distance_m = kCell_m * std::hypot(c - column, r - row);
          grid.at({c, r}) = std::max(grid.at({c, r}), grid.inflation.cost_at(distance_m));
        }
    }
}

GridPlannerParams params_of(BaseKind base) {
  GridPlannerParams params;
  params.base = base;
  return params;
}

/// Two rooms of 3 m with a wall of 0.15 m between them and a door in it.
CostGrid two_rooms(double door_m, double door_y_m = 1.5) {
  CostGrid grid = floor_of(6, 3);
  block(grid, 0, 0, 6, 0.05);
  block(grid, 0, 2.95, 6, 3);
  block(grid, 0, 0, 0.05, 3);
  block(grid, 5.95, 0, 6, 3);
  block(grid, 2.95, 0, 3.1, door_y_m - 0.5 * door_m);
  block(grid, 2.95, door_y_m + 0.5 * door_m, 3.1, 3);
  return grid;
}

TEST(GridPlanner, RefusesParametersOutOfTheirRange) {
  const auto wrong = [](auto change) {
    GridPlannerParams params;
    change(params);
    EXPECT_THROW((void)make_grid_planner(params), std::invalid_argument);
  };
  wrong([](GridPlannerParams& p) { p.neutral_cost = 0; });
  wrong([](GridPlannerParams& p) { p.neutral_cost = 253; });
  wrong([](GridPlannerParams& p) { p.cost_factor = -1; });
  wrong([](GridPlannerParams& p) { p.default_tolerance_m = 11; });
  wrong([](GridPlannerParams& p) { p.max_time_s = 0; });
  wrong([](GridPlannerParams& p) { p.heading_weight = std::nan(""); });
}

// 0.9 m long, 0.55 m wide, a door of 0.7 m: from any heading to any.
TEST(GridPlanner, PassesANarrowDoorByRotating) {
  const Footprint footprint = rectangle(0.9, 0.55);
  CostGrid grid = two_rooms(0.7, 1.7);
  inflate(grid, footprint);
  for (const BaseKind base : {BaseKind::kHolonomic, BaseKind::kDifferential}) {
    const auto planner = make_grid_planner(params_of(base));
    for (const double yaw : {0.0, 1.57, 3.0, -0.8}) {
      const Pose2 start{0.9, 0.9, yaw};
      const Pose2 goal{5.0, 2.0, -0.5 * yaw};
      const auto path = planner->plan(grid, footprint, {start, goal});
      ASSERT_TRUE(path) << path.error().message;
      expect_drivable(grid, footprint, *path, start, goal);
      EXPECT_LT(length_m(*path), 1.35 * std::hypot(goal.x - start.x, goal.y - start.y));
    }
  }
}

TEST(GridPlanner, PassesABendThatNeedsRotation) {
  const Footprint footprint = rectangle(0.9, 0.55);
  CostGrid grid = floor_of(4, 4);
  block(grid, 0, 0, 4, 4);
  const auto open = [&](double left, double bottom, double right, double top) {
    for (int row = 0; row < grid.height; ++row)
      for (int column = 0; column < grid.width; ++column) {
        const Eigen::Vector2d middle = grid.middle_of({column, row});
        if (middle.x() > left && middle.x() < right && middle.y() > bottom && middle.y() < top)
          grid.at({column, row}) = kFreeCost;
      }
  };
  open(0.2, 0.2, 3.8, 1.1);  // a corridor of 0.9 m ...
  open(2.9, 0.2, 3.8, 3.8);  // ... that bends
  inflate(grid, footprint);
  const auto planner = make_grid_planner(params_of(BaseKind::kHolonomic));
  const Pose2 start{0.8, 0.65, 0};
  const Pose2 goal{3.35, 3.2, kPi / 2};
  const auto path = planner->plan(grid, footprint, {start, goal});
  ASSERT_TRUE(path) << path.error().message;
  expect_drivable(grid, footprint, *path, start, goal);
}

TEST(GridPlanner, TakesAnotherDoorWhereTheFootprintDoesNotPass) {
  const Footprint footprint = rectangle(0.9, 0.7);
  CostGrid grid = floor_of(6, 8);
  block(grid, 2.95, 0, 3.1, 1.15);
  block(grid, 2.95, 1.8, 3.1, 6.0);  // a door of 0.65 m; the circle inside the footprint has 0.7 m
  block(grid, 2.95, 7.1, 3.1, 8);    // one of 1.1 m
  const auto planner = make_grid_planner(params_of(BaseKind::kHolonomic));
  const Pose2 start{1.5, 1.5, 0};
  const Pose2 goal{4.5, 1.5, 0};
  for (const bool inflated : {false, true}) {
    CostGrid costs = grid;
    if (inflated) inflate(costs, footprint);
    const auto path = planner->plan(costs, footprint, {start, goal});
    ASSERT_TRUE(path) << path.error().message;
    expect_drivable(costs, footprint, *path, start, goal);
    EXPECT_GT(length_m(*path), 9);
  }
}

TEST(GridPlanner, SaysWhichPassageIsTooNarrow) {
  const Footprint footprint = rectangle(0.9, 0.55);
  for (const double door_m : {0.4, 0.55}) {
    CostGrid grid = two_rooms(door_m);
    inflate(grid, footprint);
    const auto planner = make_grid_planner(params_of(BaseKind::kHolonomic));
    const auto path = planner->plan(grid, footprint, {{1, 1.5, 0}, {5, 1.5, 0}});
    ASSERT_FALSE(path);
    EXPECT_EQ(NavCode::kNoPath, path.error().code);
    ASSERT_TRUE(path.error().where);
    EXPECT_NEAR(3.0, path.error().where->x, 0.8) << path.error().message;
    EXPECT_NEAR(1.5, path.error().where->y, 0.5) << path.error().message;
  }
}

TEST(GridPlanner, KeepsTheFootprintOffUnknownSpaceUnlessItIsAllowed) {
  const Footprint footprint = rectangle(0.6, 0.4);
  CostGrid grid = floor_of(6, 3);
  for (int row = 0; row < grid.height; ++row)
    for (int column = 50; column < 60; ++column)
      if (row < 40) grid.at({column, row}) = kUnknownCost;
  const Pose2 start{1, 1, 0};
  const Pose2 goal{5, 1, 0};
  const auto around = make_grid_planner({})->plan(grid, footprint, {start, goal});
  ASSERT_TRUE(around) << around.error().message;
  expect_drivable(grid, footprint, *around, start, goal);
  GridPlannerParams params;
  params.allow_unknown = true;
  params.cost_factor = 0;
  const auto through = make_grid_planner(params)->plan(grid, footprint, {start, goal});
  ASSERT_TRUE(through) << through.error().message;
  EXPECT_NEAR(4, length_m(*through), 0.05);
  EXPECT_GT(length_m(*around), 4.5);
}

TEST(GridPlanner, ADifferentialBaseHeadsAlongItsPath) {
  CostGrid grid = two_rooms(1.2);
  const Footprint footprint = rectangle(0.6, 0.4);
  inflate(grid, footprint);
  const Pose2 start{1, 0.8, 2};
  const Pose2 goal{5, 2, 2};
  const auto path =
      make_grid_planner(params_of(BaseKind::kDifferential))->plan(grid, footprint, {start, goal});
  ASSERT_TRUE(path) << path.error().message;
  expect_drivable(grid, footprint, *path, start, goal);
  for (std::size_t i = 1; i < path->poses.size(); ++i) {
    const Pose2& from = path->poses[i - 1];
    const Pose2& to = path->poses[i];
    if (std::hypot(to.x - from.x, to.y - from.y) < 1e-6) continue;
    const double motion = std::atan2(to.y - from.y, to.x - from.x);
    EXPECT_LT(std::min(std::abs(wrap_angle(motion - to.yaw)), std::abs(wrap_angle(motion + kPi - to.yaw))),
              0.06);
  }
}

/// Rooms with a wall of 0.7 m through the middle, at an angle, and a passage in it.
CostGrid slanted_rooms(double angle, double door_m) {
  CostGrid grid = floor_of(7, 7);
  for (int row = 0; row < grid.height; ++row)
    for (int column = 0; column < grid.width; ++column) {
      const Eigen::Vector2d at = grid.middle_of({column, row}) - Eigen::Vector2d(3.5, 3.5);
      const double across = std::cos(angle) * at.x() + std::sin(angle) * at.y();
      const double along = -std::sin(angle) * at.x() + std::cos(angle) * at.y();
      if (std::abs(across) < 0.35 && std::abs(along) > 0.5 * door_m) grid.at({column, row}) = kLethalCost;
    }
  return grid;
}

// A base as wide as that of the reference, a passage as wide as the office's doors.
TEST(GridPlanner, ADifferentialBasePassesATightPassageAtAnyAngle) {
  const Footprint footprint = rectangle(0.81, 0.83);
  const auto planner = make_grid_planner(params_of(BaseKind::kDifferential));
  for (const double angle : {0.0, 0.1, 0.2, 0.35, 0.5, 0.7}) {
    SCOPED_TRACE(angle);
    CostGrid grid = slanted_rooms(angle, 0.95);
    inflate(grid, footprint);
    const Pose2 start{1.2, 2.2, 2.5};
    const Pose2 goal{5.8, 5.2, -1};
    const auto path = planner->plan(grid, footprint, {start, goal});
    ASSERT_TRUE(path) << path.error().message;
    expect_drivable(grid, footprint, *path, start, goal);
    EXPECT_LT(length_m(*path), 1.3 * std::hypot(goal.x - start.x, goal.y - start.y));
  }
}

// It stands in a passage where it cannot rotate and leaves it ahead or backwards, or has its goal there.
TEST(GridPlanner, ADifferentialBaseLeavesAndReachesAPassageInWhichItCannotRotate) {
  const Footprint footprint = rectangle(0.81, 0.83);
  const auto planner = make_grid_planner(params_of(BaseKind::kDifferential));
  for (const double angle : {0.0, 0.2, 0.6}) {
    CostGrid grid = slanted_rooms(angle, 0.95);
    inflate(grid, footprint);
    for (const double yaw : {angle, angle + 0.03, angle - kPi}) {
      SCOPED_TRACE(testing::Message() << "wall " << angle << " yaw " << yaw);
      const Pose2 door{3.5, 3.5, wrap_angle(yaw)};
      for (const Pose2& room : {Pose2{1, 1.8, 1}, Pose2{1.5, 4.2, 3}, Pose2{5.5, 3.5, 0}}) {
        const auto out = planner->plan(grid, footprint, {door, room});
        ASSERT_TRUE(out) << out.error().message;
        expect_drivable(grid, footprint, *out, door, room);
        const auto in = planner->plan(grid, footprint, {room, door});
        ASSERT_TRUE(in) << in.error().message;
        expect_drivable(grid, footprint, *in, room, door);
      }
    }
  }
}

/// Two rooms of 8 x 4 m with a door of 0.96 m in between, whose leaf stands open by 80 degrees in the lower
/// one.
CostGrid rooms_with_leaf() {
  CostGrid grid = floor_of(8, 8);
  block(grid, 0, 3.95, 3.5, 4.1);
  block(grid, 4.5, 3.95, 8, 4.1);
  for (double along_m = 0; along_m < 0.9; along_m += 0.01) {
    const Eigen::Vector2d at(3.52 + 0.17 * along_m, 4.0 - 0.985 * along_m);
    grid.at(grid.cell_around(at)) = kLethalCost;
  }
  return grid;
}

// In a door it cannot straighten up any more.
TEST(GridPlanner, ADifferentialBaseRotatesBeforeADoorAndNotInIt) {
  const Footprint footprint = rectangle(0.78, 0.76);
  CostGrid grid = rooms_with_leaf();
  inflate(grid, footprint);
  const auto planner = make_grid_planner(params_of(BaseKind::kDifferential));
  Rng rng(3);
  int rotates = 0;
  constexpr int kTrips = 30;
  for (int trip = 0; trip < kTrips; ++trip) {
    Pose2 start{rng.uniform(1, 7), rng.uniform(5, 7), rng.uniform(-3, 3)};
    Pose2 goal{rng.uniform(2, 6), rng.uniform(0.8, 2.2), rng.uniform(-3, 3)};
    if (trip % 2 == 1) std::swap(start, goal);
    const auto path = planner->plan(grid, footprint, {start, goal});
    ASSERT_TRUE(path) << path.error().message;
    expect_drivable(grid, footprint, *path, start, goal);
    double rotation_rad = 0;
    for (std::size_t i = 1; i < path->poses.size(); ++i)
      if (std::abs(path->poses[i].y - 4.0) < 0.4)
        rotation_rad += std::abs(wrap_angle(path->poses[i].yaw - path->poses[i - 1].yaw));
    if (rotation_rad > 0.2) ++rotates;
  }
  EXPECT_LE(rotates, kTrips / 10);
}

TEST(GridPlanner, ADifferentialBaseDrivesCurvesWhereThereIsRoom) {
  const Footprint footprint = rectangle(0.6, 0.4);
  CostGrid grid = floor_of(8, 6);
  block(grid, 0, 2.5, 5, 3.5);
  inflate(grid, footprint);
  const Pose2 start{1, 1.2, 0.3};
  const Pose2 goal{1, 4.8, -2.8};
  const auto path =
      make_grid_planner(params_of(BaseKind::kDifferential))->plan(grid, footprint, {start, goal});
  ASSERT_TRUE(path) << path.error().message;
  expect_drivable(grid, footprint, *path, start, goal);
  double rotation_rad = 0;
  for (std::size_t i = 1; i < path->poses.size(); ++i)
    if (distance_m(path->poses[i - 1], path->poses[i]) < 1e-6)
      rotation_rad += std::abs(wrap_angle(path->poses[i].yaw - path->poses[i - 1].yaw));
  EXPECT_LT(rotation_rad, 0.06);
}

TEST(GridPlanner, AHolonomicBaseKeepsItsYawWithoutHeadingWeight) {
  CostGrid grid = floor_of(6, 3);
  const Footprint footprint = rectangle(0.6, 0.4);
  GridPlannerParams params;
  params.heading_weight = 0;
  const auto kept = make_grid_planner(params)->plan(grid, footprint, {{1, 1, 1.5}, {5, 2, 1.5}});
  ASSERT_TRUE(kept) << kept.error().message;
  for (const Pose2& pose : kept->poses) EXPECT_NEAR(1.5, pose.yaw, 1e-6);
  params.heading_weight = 1;
  const auto along = make_grid_planner(params)->plan(grid, footprint, {{1, 1, 1.5}, {5, 2, 1.5}});
  ASSERT_TRUE(along) << along.error().message;
  EXPECT_NEAR(std::atan2(1, 4), along->poses[along->poses.size() / 2].yaw, 0.1);
}

TEST(GridPlanner, KeepsAwayFromObstaclesAsCostFactorSays) {
  const Footprint footprint = rectangle(0.4, 0.4);
  CostGrid grid = floor_of(8, 4);
  block(grid, 3, 0, 5, 1.5);
  inflate(grid, footprint);
  const auto clearance_m = [&](double cost_factor) {
    GridPlannerParams params;
    params.cost_factor = cost_factor;
    const auto path = make_grid_planner(params)->plan(grid, footprint, {{1, 0.6, 0}, {7, 0.6, 0}});
    EXPECT_TRUE(path);
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const Pose2& pose : path->poses)
      if (pose.x > 3 && pose.x < 5) nearest_m = std::min(nearest_m, pose.y - 1.5);
    return nearest_m;
  };
  EXPECT_LT(clearance_m(0), 0.3);
  EXPECT_GT(clearance_m(10), 0.45);
}

TEST(GridPlanner, StopsWhenItsTimeIsOver) {
  GridPlannerParams params;
  params.max_time_s = 1e-9;
  const auto path =
      make_grid_planner(params)->plan(floor_of(6, 3), rectangle(0.6, 0.4), {{1, 1, 0}, {5, 2, 0}});
  ASSERT_FALSE(path);
  EXPECT_EQ(NavCode::kPlanTimeout, path.error().code);
}

// Whatever it returns is drivable, on bare and on inflated maps of random boxes; a failure has a place.
TEST(GridPlanner, RandomFloorsNeverTouch) {
  const Footprint footprint = rectangle(0.81, 0.79);
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Rng rng(seed);
    CostGrid grid = floor_of(10, 8);
    for (int k = 0; k < 14; ++k) {
      const double x = rng.uniform(1, 9);
      const double y = rng.uniform(0, 8);
      block(grid, x, y, x + rng.uniform(0.1, 1.5), y + rng.uniform(0.1, 1.5));
    }
    if (seed % 3 != 0) inflate(grid, footprint);
    const BaseKind base = seed % 2 == 0 ? BaseKind::kHolonomic : BaseKind::kDifferential;
    const Pose2 start{0.6, rng.uniform(1, 7), rng.uniform(-3, 3)};
    const Pose2 goal{9.3, rng.uniform(1, 7), rng.uniform(-3, 3)};
    const auto path = make_grid_planner(params_of(base))->plan(grid, footprint, {start, goal});
    if (path) {
      expect_drivable(grid, footprint, *path, start, goal);
      ++found;
    } else {
      EXPECT_TRUE(path.error().where) << path.error().message;
    }
  }
  EXPECT_GT(found, 4);
}

}  // namespace

}  // namespace extperfc::navigate
