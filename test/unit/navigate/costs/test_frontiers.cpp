// Frontiers: generated floors are explored until nothing is left, and nowhere else.
#include <algorithm>
#include <cmath>
#include <queue>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/exploration.hpp"
#include "extperfc/navigate/frontiers.hpp"
#include "extperfc/navigate/static_layer.hpp"

namespace extperfc::navigate {
namespace {

using Eigen::Vector2d;

const Footprint& chassis() {
  static const Footprint footprint =
      Footprint::make({{-0.4064, -0.3937}, {0.4064, -0.3937}, {0.4064, 0.3937}, {-0.4064, 0.3937}}).value();
  return footprint;
}

void fill(CostGrid& grid, double x0, double y0, double x1, double y1, Cost cost) {
  for (int row = 0; row < grid.height; ++row)
    for (int column = 0; column < grid.width; ++column) {
      const Vector2d m = grid.middle_of({column, row});
      if (m.x() > x0 && m.x() < x1 && m.y() > y0 && m.y() < y1) grid.at({column, row}) = cost;
    }
}

CostGrid unknown_floor(double width_m, double height_m) {
  return make_cost_grid(static_cast<int>(width_m / 0.1), static_cast<int>(height_m / 0.1), 0.1, {0, 0},
                        kUnknownCost);
}

NavResult<FrontierList> find(const CostGrid& grid, const FrontierQuery& query,
                             const FrontierParams& params = {}) {
  return find_frontiers(grid, chassis(), query, params);
}

/// Rooms of 4 m by 4 m with walls of 0.2 m, doors in a spanning tree and some more; clutter.
CostGrid random_floor(Rng& rng, int columns, int rows) {
  CostGrid grid = unknown_floor(4.0 * columns + 0.2, 4.0 * rows + 0.2);
  fill(grid, 0, 0, 100, 100, kFreeCost);
  for (int i = 0; i <= columns; ++i) fill(grid, 4 * i, 0, 4 * i + 0.2, 100, kLethalCost);
  for (int i = 0; i <= rows; ++i) fill(grid, 0, 4 * i, 100, 4 * i + 0.2, kLethalCost);
  for (int column = 0; column < columns; ++column)
    for (int row = 0; row < rows; ++row) {
      const double along = rng.uniform(1, 2);
      if (column > 0 && (row == 0 || rng.chance(0.4)))
        fill(grid, 4 * column - 0.05, 4 * row + along, 4 * column + 0.25, 4 * row + along + 1.2, kFreeCost);
      if (row > 0)
        fill(grid, 4 * column + along, 4 * row - 0.05, 4 * column + along + 1.2, 4 * row + 0.25, kFreeCost);
      const double x = 4 * column + rng.uniform(0.5, 3), y = 4 * row + rng.uniform(2.8, 3.3);
      fill(grid, x, y, x + 0.4, y + 0.4, kLethalCost);
    }
  return grid;
}

/// What a lidar with a range of 3 m sees, into the map.
void look(const CostGrid& truth, CostGrid& map, const Pose2& pose) {
  for (int i = 0; i < 720; ++i) {
    const double angle = kTwoPi * i / 720;
    for (double r = 0; r < 3; r += 0.03) {
      const auto cell = truth.cell_of({pose.x + r * std::cos(angle), pose.y + r * std::sin(angle)});
      if (!cell) break;
      map.at(*cell) = truth.at(*cell);
      if (truth.at(*cell) == kLethalCost) break;
    }
  }
}

/// Cells that the middle of a disc reaches, one cell wider than the chassis' inscribed circle.
std::vector<bool> reachable(const CostGrid& truth, const Pose2& pose) {
  const auto is_open = [&](Cell cell) {
    for (int row = -5; row <= 5; ++row)
      for (int column = -5; column <= 5; ++column) {
        const Cell other{cell.column + column, cell.row + row};
        if (column * column + row * row <= 25 && (!truth.contains(other) || truth.at(other) == kLethalCost))
          return false;
      }
    return true;
  };
  std::vector<bool> reached(truth.cells.size(), false);
  std::vector<Cell> queue{*truth.cell_of({pose.x, pose.y})};
  for (std::size_t i = 0; i < queue.size(); ++i)
    for (const Cell step : {Cell{1, 0}, Cell{-1, 0}, Cell{0, 1}, Cell{0, -1}}) {
      const Cell next{queue[i].column + step.column, queue[i].row + step.row};
      if (!truth.contains(next) || reached[truth.index(next)] || !is_open(next)) continue;
      reached[truth.index(next)] = true;
      queue.push_back(next);
    }
  return reached;
}

TEST(Frontiers, FloorsAreExploredToTheEnd) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Rng rng(seed);
    const CostGrid truth = random_floor(rng, 3, 2);
    CostGrid map = truth;
    std::fill(map.cells.begin(), map.cells.end(), kUnknownCost);
    Pose2 pose{1, 1, 0};
    int goals = 0;
    for (;; ++goals) {
      look(truth, map, pose);
      const auto list = find(map, {pose});
      ASSERT_TRUE(list) << list.error().message << ", seed " << seed;
      if (list->frontiers.empty()) break;
      ASSERT_LT(goals, 60) << "seed " << seed;
      const Frontier& best = list->frontiers.front();
      EXPECT_EQ(contact(map, chassis(), best.goal), Contact::kFree);
      EXPECT_EQ(contact(truth, chassis(), best.goal), Contact::kFree);
      EXPECT_GE(best.path_m + 1e-6, std::hypot(best.goal.x - pose.x, best.goal.y - pose.y) - 1.0);
      pose = best.goal;
    }
    const std::vector<bool> reached = reachable(truth, {1, 1, 0});
    std::size_t hidden = 0;
    for (std::size_t i = 0; i < truth.cells.size(); ++i)
      hidden += reached[i] && map.cells[i] == kUnknownCost ? 1 : 0;
    EXPECT_EQ(hidden, 0U) << "seed " << seed;
    EXPECT_GT(std::count(reached.begin(), reached.end(), true), 1000);
    EXPECT_GT(goals, 3);
  }
}

TEST(Frontiers, KnownFloorHasNone) {
  Rng rng(1);
  const auto list = find(random_floor(rng, 2, 2), {{1, 1, 0}});
  ASSERT_TRUE(list);
  EXPECT_TRUE(list->frontiers.empty());
  EXPECT_EQ(list->without_goal, 0U);
}

/// A corridor along x from 0 to 10 m, unknown from 6 m on.
CostGrid corridor() {
  CostGrid grid = unknown_floor(10, 4);
  fill(grid, 0, 0, 6, 4, kFreeCost);
  fill(grid, 0, 0, 10, 0.2, kLethalCost);
  fill(grid, 0, 3.8, 10, 4, kLethalCost);
  fill(grid, 0, 0, 0.2, 4, kLethalCost);
  return grid;
}

TEST(Frontiers, SizeCentroidAndGoal) {
  const auto list = find(corridor(), {{2, 2, 0}});
  ASSERT_TRUE(list);
  ASSERT_EQ(list->frontiers.size(), 1U);
  const Frontier& frontier = list->frontiers.front();
  EXPECT_NEAR(frontier.centroid_m.x(), 5.95, 1e-9);
  EXPECT_NEAR(frontier.centroid_m.y(), 2.0, 0.1);
  EXPECT_NEAR(frontier.length_m, 3.6, 1e-6);
  EXPECT_NEAR(frontier.goal.x, 6 - 0.4064 - 0.05, 0.11);
  EXPECT_NEAR(frontier.goal.yaw, 0, 0.3);
  EXPECT_NEAR(frontier.path_m, frontier.goal.x - 2, 0.3);
  EXPECT_NEAR(frontier.score, frontier.length_m - frontier.path_m, 1e-9);
}

TEST(Frontiers, LongOnesAreCut) {
  CostGrid grid = unknown_floor(20, 10);
  fill(grid, 0, 0, 20, 5, kFreeCost);
  const auto list = find(grid, {{2, 2, 0}});
  ASSERT_TRUE(list);
  EXPECT_GE(list->frontiers.size(), 4U);
  for (const Frontier& frontier : list->frontiers) EXPECT_LE(frontier.length_m, 4.01);
  for (std::size_t i = 1; i < list->frontiers.size(); ++i)
    EXPECT_LE(list->frontiers[i].score, list->frontiers[i - 1].score);
}

TEST(Frontiers, NarrowGapsAndRaggedWallsAreNone) {
  CostGrid grid = corridor();
  fill(grid, 5.7, 0, 10, 4, kLethalCost);
  fill(grid, 5.7, 1.7, 10, 2.3, kUnknownCost);  // a gap of 0.6 m: narrower than the robot
  for (int column = 5; column < 50; column += 7) grid.at({column, 38}) = grid.at({column, 39}) = kUnknownCost;
  const auto list = find(grid, {{2, 2, 0}});
  ASSERT_TRUE(list);
  EXPECT_TRUE(list->frontiers.empty());
  fill(grid, 5.7, 1.4, 10, 2.6, kUnknownCost);
  EXPECT_EQ(find(grid, {{2, 2, 0}}, {0.1})->frontiers.size(), 1U);
}

TEST(Frontiers, SlackLeadsThroughGapsThatCellsMakeNarrow) {
  CostGrid grid = corridor();
  fill(grid, 3, 0, 3.2, 4, kLethalCost);
  fill(grid, 2.95, 1.7, 3.25, 2.3, kFreeCost);
  EXPECT_TRUE(find(grid, {{2, 2, 0}})->frontiers.empty());
  FrontierParams params;
  params.passage_slack_m = 0.1;
  EXPECT_EQ(find(grid, {{2, 2, 0}}, params)->frontiers.size(), 1U);
  params.passage_slack_m = -0.01;
  EXPECT_EQ(find(grid, {{2, 2, 0}}, params).error().code, NavCode::kInvalidRequest);
}

TEST(Frontiers, DoorwaysCountWithTheirWholeWidth) {
  CostGrid grid = corridor();
  fill(grid, 3, 0, 10, 4, kUnknownCost);
  fill(grid, 2.8, 0, 3, 4, kLethalCost);
  fill(grid, 2.75, 1.6, 3.05, 2.5, kFreeCost);  // 0.9 m, in 0.3 m of which the inscribed circle may be
  const auto list = find(grid, {{1.5, 2, 0}});
  ASSERT_EQ(list->frontiers.size(), 1U);
  EXPECT_NEAR(list->frontiers[0].length_m, 0.9, 1e-6);
}

TEST(Frontiers, BehindAWallIsNotReachable) {
  CostGrid grid = corridor();
  fill(grid, 4, 0, 4.2, 4, kLethalCost);
  const auto list = find(grid, {{2, 2, 0}});
  ASSERT_TRUE(list);
  EXPECT_TRUE(list->frontiers.empty());
  EXPECT_EQ(find(grid, {{5, 2, 0}})->frontiers.size(), 1U);
}

TEST(Frontiers, WhereTheFootprintFitsNowhere) {
  // The disc fits through 0.9 m; a long bar does not.
  const auto bar = Footprint::make({{-1.5, -0.1}, {1.5, -0.1}, {1.5, 0.1}, {-1.5, 0.1}}).value();
  CostGrid grid = unknown_floor(10, 4);
  fill(grid, 0, 0, 3, 4, kFreeCost);
  fill(grid, 3, 0, 3.2, 4, kLethalCost);
  fill(grid, 2.9, 1.8, 3.3, 2.2, kFreeCost);
  fill(grid, 3.2, 1.8, 3.4, 2.2, kFreeCost);
  fill(grid, 0, 0, 0.2, 4, kLethalCost);
  fill(grid, 0, 0, 3.2, 0.2, kLethalCost);
  fill(grid, 0, 3.8, 3.2, 4, kLethalCost);
  const auto list = find_frontiers(grid, bar, {{1.6, 2, kPi / 2}}, {0.1, 4, 1, 0.3});
  ASSERT_TRUE(list);
  EXPECT_TRUE(list->frontiers.empty());
  EXPECT_EQ(list->without_goal, 1U);
}

TEST(Frontiers, BlacklistAndBounds) {
  const CostGrid grid = corridor();
  const Vector2d goal_m(find(grid, {{2, 2, 0}})->frontiers.front().goal.x, 2);
  auto list = find(grid, {{2, 2, 0}, {}, {goal_m}});
  EXPECT_TRUE(list->frontiers.empty());
  EXPECT_EQ(list->blacklisted, 1U);
  list = find(grid, {{2, 2, 0}, {}, {goal_m - Vector2d(2, 0)}});
  EXPECT_EQ(list->frontiers.size(), 1U);
  list = find(grid, {{2, 2, 0}, {{0, 0}, {5, 0}, {5, 4}, {0, 4}}});
  EXPECT_TRUE(list->frontiers.empty());
  list = find(grid, {{2, 2, 0}, {{0, 0}, {8, 0}, {8, 2}, {0, 2}}});
  ASSERT_EQ(list->frontiers.size(), 1U);
  for (const auto& point_m : list->frontiers[0].points_m) EXPECT_LT(point_m.y(), 2);
}

TEST(Frontiers, UnknownMayBeTouchedWhenAllowed) {
  FrontierParams params;
  params.allow_unknown = true;
  const auto list = find(corridor(), {{2, 2, 0}}, params);
  ASSERT_EQ(list->frontiers.size(), 1U);
  EXPECT_NEAR(list->frontiers[0].goal.x, 5.95, 1e-6);
}

TEST(Frontiers, StartThatIsNotFreeIsMovedALittle) {
  CostGrid grid = corridor();
  fill(grid, 1.9, 1.9, 2.1, 2.1, kUnknownCost);  // a blind spot under the robot
  EXPECT_TRUE(find(grid, {{2, 2, 0}}));
  EXPECT_TRUE(find(grid, {{0.45, 2, 0}}));  // nearer to the wall than its inscribed radius
  FrontierParams strict;
  strict.start_tolerance_m = 0;
  const auto blocked = find(grid, {{0.45, 2, 0}}, strict);
  ASSERT_FALSE(blocked);
  EXPECT_EQ(blocked.error().code, NavCode::kStartBlocked);
}

TEST(Frontiers, RefusesWhatCannotBe) {
  const CostGrid grid = corridor();
  EXPECT_EQ(find(grid, {{-1, 2, 0}}).error().code, NavCode::kStartOutside);
  EXPECT_EQ(find(grid, {{std::nan(""), 2, 0}}).error().code, NavCode::kInvalidRequest);
  EXPECT_EQ(find(grid, {{2, 2, 0}, {{0, std::nan("")}}}).error().code, NavCode::kInvalidRequest);
  EXPECT_EQ(find(grid, {{2, 2, 0}}, {0}).error().code, NavCode::kInvalidRequest);
  EXPECT_EQ(find({}, {{2, 2, 0}}).error().code, NavCode::kNoMap);
}

TEST(Exploration, EndsAlthoughAFrontierStays) {
  // Behind the frontier nothing is ever seen, as behind glass.
  const CostGrid grid = corridor();
  Exploration exploration(chassis(), {}, {});
  Pose2 pose{2, 2, 0};
  int goals = 0;
  for (;; ++goals) {
    ASSERT_LT(goals, 20);
    const auto next = exploration.next(grid, pose);
    ASSERT_TRUE(next);
    if (!*next) break;
    pose = (*next)->goal;
    exploration.reached();
  }
  EXPECT_GE(goals, 1);
  EXPECT_EQ(exploration.goals_reached(), static_cast<std::size_t>(goals));
}

TEST(Exploration, FailedGoalsAreLeftOut) {
  const CostGrid grid = corridor();
  Exploration exploration(chassis(), {}, {});
  ASSERT_TRUE(*exploration.next(grid, {2, 2, 0}));
  EXPECT_EQ(exploration.frontiers_left(), 1U);
  exploration.failed();
  ASSERT_TRUE(*exploration.next(grid, {2, 2, 0}));  // a second chance
  EXPECT_EQ(exploration.blacklisted(), 0U);
  exploration.failed();
  EXPECT_FALSE(*exploration.next(grid, {2, 2, 0}));
  EXPECT_EQ(exploration.blacklisted(), 1U);
  EXPECT_EQ(exploration.goals_failed(), 2U);
}

TEST(Exploration, SecondChanceComesAfterAllOthers) {
  CostGrid grid = corridor();
  fill(grid, 0, 0.2, 0.2, 3.8, kUnknownCost);  // a second frontier, on the other side
  Exploration exploration(chassis(), {}, {});
  const auto first = exploration.next(grid, {2, 2, 0});
  ASSERT_TRUE(first && *first);
  exploration.failed();
  const auto second = exploration.next(grid, {2, 2, 0});
  ASSERT_TRUE(second && *second);
  EXPECT_GT(std::abs((*second)->goal.x - (*first)->goal.x), 2);
  exploration.failed();
  for (int chance = 0; chance < 2; ++chance) {
    ASSERT_TRUE(*exploration.next(grid, {2, 2, 0}));
    exploration.failed();
  }
  EXPECT_FALSE(*exploration.next(grid, {2, 2, 0}));
}

TEST(Exploration, TightPassagesComeLast) {
  CostGrid grid = corridor();
  fill(grid, 3, 0, 3.2, 4, kLethalCost);
  fill(grid, 2.95, 1.7, 3.25, 2.3, kFreeCost);  // 0.6 m
  fill(grid, 0, 0.2, 0.2, 1.2, kUnknownCost);   // a smaller frontier on this side
  FrontierParams params;
  params.passage_slack_m = 0.1;
  ASSERT_EQ(find(grid, {{2, 2, 0}}, params)->frontiers.size(), 2U);
  EXPECT_GT(find(grid, {{2, 2, 0}}, params)->frontiers.front().goal.x, 3);
  Exploration exploration(chassis(), params, {});
  const auto first = exploration.next(grid, {2, 2, 0});
  ASSERT_TRUE(first && *first);
  EXPECT_LT((*first)->goal.x, 3);
  fill(grid, 0, 0.2, 0.2, 1.2, kLethalCost);
  const auto second = exploration.next(grid, {2, 2, 0});
  ASSERT_TRUE(second && *second);
  EXPECT_GT((*second)->goal.x, 3);
}

TEST(Exploration, GoalsThatCannotBeReachedAreLeftOutForNow) {
  CostGrid grid = corridor();
  fill(grid, 0, 0.2, 0.2, 3.8, kUnknownCost);
  Exploration exploration(chassis(), {}, {});
  const auto left_only = [](const Pose2& goal) { return goal.x < 3; };
  const auto left = exploration.next(grid, {2, 2, 0}, left_only);
  ASSERT_TRUE(left && *left);
  EXPECT_LT((*left)->goal.x, 3);
  EXPECT_FALSE(*exploration.next(grid, {2, 2, 0}, [](const Pose2&) { return false; }));
  EXPECT_EQ(exploration.unreachable(), 2U);
  EXPECT_EQ(exploration.frontiers_left(), 2U);
  EXPECT_TRUE(*exploration.next(grid, {2, 2, 0}));  // a door was opened
  EXPECT_EQ(exploration.unreachable(), 0U);
}

TEST(Exploration, GoalIsOutdatedOnceItsFrontierIsKnown) {
  CostGrid grid = corridor();
  Exploration exploration(chassis(), {}, {});
  EXPECT_FALSE(exploration.is_outdated(grid));
  ASSERT_TRUE(*exploration.next(grid, {2, 2, 0}));
  EXPECT_FALSE(exploration.is_outdated(grid));
  fill(grid, 6, 0.2, 8, 2, kFreeCost);  // half of it
  EXPECT_FALSE(exploration.is_outdated(grid));
  fill(grid, 6, 0.2, 8, 3.8, kFreeCost);
  EXPECT_TRUE(exploration.is_outdated(grid));
}

TEST(Frontiers, OfAMapAsTheMapperPublishesIt) {
  OccupancyGrid map;
  map.width = 100;
  map.height = 40;
  map.resolution_m = 0.1;
  map.origin = {-3, -1, 0};
  const CostGrid grid = corridor();
  for (const Cost cost : grid.cells)
    map.cells.push_back(cost == kUnknownCost ? OccupancyGrid::kUnknown
                        : cost == kFreeCost  ? std::int8_t{10}
                                             : OccupancyGrid::kOccupied);
  const auto list = find(costs_of(map), {{-1, 1, 0}});
  ASSERT_TRUE(list);
  ASSERT_EQ(list->frontiers.size(), 1U);
  EXPECT_NEAR(list->frontiers[0].centroid_m.x(), 2.95, 1e-6);
}

}  // namespace
}  // namespace extperfc::navigate
