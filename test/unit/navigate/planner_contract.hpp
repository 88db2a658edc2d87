#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <ostream>
#include <queue>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/navigate/global_planner.hpp"

#include "test/unit/navigate/planned_path.hpp"

namespace extperfc::navigate::contract {

inline constexpr double kCell_m = 0.1;  ///< of the suite's maps

/// What every global planner must keep to. Instantiate:
/// INSTANTIATE_TEST_SUITE_P(Name, PlannerContract, testing::Values(PlannerCase{...}), case_name);
struct PlannerCase {
  std::string name;
  std::function<std::unique_ptr<GlobalPlanner>()> make;
  double bound{1.02};               ///< its length is at most this times the reference's ...
  double extra_m{0.1};              ///< ... and this
  const char* known_miss{nullptr};  ///< why random maps are skipped
};

inline void PrintTo(const PlannerCase& planner, std::ostream* out) {
  *out << planner.name;
}

inline std::string case_name(const testing::TestParamInfo<PlannerCase>& info) {
  return info.param.name;
}

/// Rows from the top: '#' lethal, '?' unknown, anything else free.
inline CostGrid draw(const std::vector<std::string>& rows, double resolution_m = kCell_m) {
  const int height = static_cast<int>(rows.size());
  CostGrid grid =
      make_cost_grid(static_cast<int>(rows[0].size()), height, resolution_m, {-1.3, 2.1}, kFreeCost);
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < grid.width; ++column) {
      const char cell = rows[static_cast<std::size_t>(height - 1 - row)][static_cast<std::size_t>(column)];
      grid.at({column, row}) = cell == '#' ? kLethalCost : cell == '?' ? kUnknownCost : kFreeCost;
    }
  return grid;
}

/// Free cells with random lethal ones.
inline CostGrid random_map(int side, double filled, std::uint64_t seed) {
  Rng rng(seed);
  CostGrid grid = make_cost_grid(side, side, kCell_m, {-0.7, 0.4}, kFreeCost);
  for (Cost& cell : grid.cells)
    if (rng.chance(filled)) cell = kLethalCost;
  return grid;
}

inline Pose2 pose_in(const CostGrid& grid, Cell cell, double yaw = 0) {
  const Eigen::Vector2d middle = grid.middle_of(cell);
  return {middle.x(), middle.y(), yaw};
}

/// Lengths [m] of shortest paths over eight neighbours, diagonally only between two free cells; infinite
/// where there is none.
inline std::vector<double> reference_lengths_m(const CostGrid& grid, Cell from) {
  std::vector<double> length(grid.cells.size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const auto free = [&](Cell cell) { return grid.contains(cell) && grid.at(cell) == kFreeCost; };
  length[grid.index(from)] = 0;
  open.emplace(0, grid.index(from));
  while (!open.empty()) {
    const auto [reached, index] = open.top();
    open.pop();
    if (reached > length[index]) continue;
    const int column = static_cast<int>(index) % grid.width;
    const int row = static_cast<int>(index) / grid.width;
    for (int dr = -1; dr <= 1; ++dr)
      for (int dc = -1; dc <= 1; ++dc) {
        const Cell to{column + dc, row + dr};
        if (!free(to) || !free({column + dc, row}) || !free({column, row + dr})) continue;
        const double next = reached + grid.resolution_m * std::hypot(dc, dr);
        if (next >= length[grid.index(to)] - 1e-12) continue;
        length[grid.index(to)] = next;
        open.emplace(next, grid.index(to));
      }
  }
  return length;
}

class PlannerContract : public testing::TestWithParam<PlannerCase> {
 protected:
  void SetUp() override { planner_ = GetParam().make(); }

  NavResult<Path> plan(const CostGrid& grid, const Pose2& start, const Pose2& goal, double tolerance_m = 0) {
    return planner_->plan(grid, footprint_, {start, goal, tolerance_m, nullptr});
  }
  NavCode code(const CostGrid& grid, const Pose2& start, const Pose2& goal, double tolerance_m = 0) {
    const auto path = plan(grid, start, goal, tolerance_m);
    if (path) return NavCode::kSuccess;
    EXPECT_FALSE(path.error().message.empty());
    return path.error().code;
  }
  /// Every free cell (every `stride`-th) to every other.
  void expect_all_pairs(const CostGrid& grid, int stride) {
    std::vector<Cell> free;
    for (int row = 0; row < grid.height; ++row)
      for (int column = 0; column < grid.width; ++column)
        if (grid.at({column, row}) == kFreeCost) free.push_back({column, row});
    int pair = 0;
    for (const Cell& from : free) {
      const auto reference = reference_lengths_m(grid, from);
      for (const Cell& to : free)
        if (pair++ % stride == 0) expect_as_reference(grid, from, to, reference[grid.index(to)]);
      if (HasFatalFailure() || HasNonfatalFailure()) return;
    }
  }
  void expect_as_reference(const CostGrid& grid, Cell from, Cell to, double reference_m) {
    SCOPED_TRACE(testing::Message() << "from cell " << from.column << " " << from.row << " to " << to.column
                                    << " " << to.row);
    const Pose2 start = pose_in(grid, from);
    const Pose2 goal = pose_in(grid, to);
    const auto path = plan(grid, start, goal);
    ASSERT_EQ(std::isfinite(reference_m), path.has_value()) << (path ? "" : path.error().message);
    if (!path) {
      EXPECT_EQ(NavCode::kNoPath, path.error().code);
      EXPECT_TRUE(path.error().where.has_value());
      return;
    }
    expect_drivable(grid, footprint_, *path, start, goal);
    EXPECT_LE(length_m(*path), GetParam().bound * reference_m + GetParam().extra_m);
  }

  Footprint footprint_ = Footprint::circle(0.03);
  std::unique_ptr<GlobalPlanner> planner_;
};

TEST_P(PlannerContract, EveryFreeCellOfRoomsToEveryOther) {
  expect_all_pairs(draw({"##########",  //
                         "#   #    #",  //
                         "#        #",  //
                         "#   # ####",  //
                         "## ## #  #",  //
                         "#     #  #",  //
                         "#  #     #",  //
                         "##########"}),
                   1);
}

TEST_P(PlannerContract, EveryFreeCellOfAreasThatAreApart) {
  expect_all_pairs(draw({"   #   ",  //
                         "   #   ",  //
                         " # # # ",  //
                         "   #  #",  //
                         "   # # "}),
                   1);
}

TEST_P(PlannerContract, RandomMaps) {
  if (GetParam().known_miss != nullptr) GTEST_SKIP() << GetParam().known_miss;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    expect_all_pairs(random_map(14, 0.1 + 0.05 * static_cast<double>(seed), seed), 101);
  }
}

TEST_P(PlannerContract, RefusesWhatIsNotFinite) {
  const CostGrid grid = draw({"    ", "    "});
  const Pose2 inside = pose_in(grid, {1, 1});
  for (const double wrong : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(NavCode::kInvalidRequest, code(grid, {wrong, inside.y, 0}, inside));
    EXPECT_EQ(NavCode::kInvalidRequest, code(grid, inside, {inside.x, wrong, 0}));
    EXPECT_EQ(NavCode::kInvalidRequest, code(grid, inside, {inside.x, inside.y, wrong}));
    EXPECT_EQ(NavCode::kInvalidRequest, code(grid, inside, inside, wrong));
  }
  EXPECT_EQ(NavCode::kInvalidRequest, code(grid, inside, inside, -0.1));
}

TEST_P(PlannerContract, NamesWhatIsWrongWithStartAndGoal) {
  const CostGrid grid = draw({"      ",  //
                              " #  ? ",  //
                              "      "});
  const Pose2 free = pose_in(grid, {0, 0});
  const Pose2 wall = pose_in(grid, {1, 1});
  const Pose2 unknown = pose_in(grid, {4, 1});
  EXPECT_EQ(NavCode::kStartOutside, code(grid, {-50, 0, 0}, free));
  EXPECT_EQ(NavCode::kGoalOutside, code(grid, free, {1e300, 0, 0}));
  EXPECT_EQ(NavCode::kStartBlocked, code(grid, wall, free));
  EXPECT_EQ(NavCode::kStartBlocked, code(grid, unknown, free));
  EXPECT_EQ(NavCode::kGoalBlocked, code(grid, free, wall));
  EXPECT_EQ(NavCode::kGoalUnknown, code(grid, free, unknown));
  EXPECT_EQ(NavCode::kStartOutside, code(CostGrid{}, free, free));
}

TEST_P(PlannerContract, MovesABlockedGoalWithinItsTolerance) {
  const CostGrid grid = draw({"        ",  //
                              "   ###  ",  //
                              "   ###  ",  //
                              "        "});
  const Pose2 start = pose_in(grid, {0, 0});
  const Pose2 goal = pose_in(grid, {4, 1}, 1.0);
  EXPECT_EQ(NavCode::kGoalBlocked, code(grid, start, goal, 0.05));
  const auto path = plan(grid, start, goal, 0.25);
  ASSERT_TRUE(path) << path.error().message;
  EXPECT_LT(std::hypot(path->poses.back().x - goal.x, path->poses.back().y - goal.y), 0.11);
  EXPECT_NEAR(1.0, path->poses.back().yaw, 1e-9);
}

TEST_P(PlannerContract, SaysWhereItIsBlocked) {
  const CostGrid grid = draw({"   #   ",  //
                              "   #   ",  //
                              "   #   "});
  const auto path = plan(grid, pose_in(grid, {0, 1}), pose_in(grid, {6, 1}));
  ASSERT_FALSE(path);
  EXPECT_EQ(NavCode::kNoPath, path.error().code);
  ASSERT_TRUE(path.error().where);
  EXPECT_NEAR(pose_in(grid, {3, 1}).x, path.error().where->x, 0.11);
}

TEST_P(PlannerContract, RotatesInPlace) {
  const CostGrid grid = draw({"   ", "   ", "   "});
  const Pose2 start = pose_in(grid, {1, 1}, 0.3);
  const Pose2 goal = pose_in(grid, {1, 1}, -2.9);
  const auto path = plan(grid, start, goal);
  ASSERT_TRUE(path) << path.error().message;
  expect_drivable(grid, footprint_, *path, start, goal);
  EXPECT_LT(length_m(*path), 0.05);
}

TEST_P(PlannerContract, SameRequestSamePath) {
  const CostGrid grid = random_map(60, 0.15, 4);
  CostGrid free = grid;
  free.at({2, 2}) = free.at({57, 55}) = kFreeCost;
  const auto first = plan(free, pose_in(free, {2, 2}), pose_in(free, {57, 55}));
  (void)plan(free, pose_in(free, {57, 55}), pose_in(free, {2, 2}));
  const auto second = plan(free, pose_in(free, {2, 2}), pose_in(free, {57, 55}));
  ASSERT_EQ(first.has_value(), second.has_value());
  if (!first) return;
  ASSERT_EQ(first->poses.size(), second->poses.size());
  for (std::size_t i = 0; i < first->poses.size(); ++i) {
    EXPECT_EQ(first->poses[i].x, second->poses[i].x);
    EXPECT_EQ(first->poses[i].yaw, second->poses[i].yaw);
  }
}

TEST_P(PlannerContract, EndsWhenCancelled) {
  const CostGrid grid = make_cost_grid(1500, 1500, 0.05, {0, 0}, kFreeCost);
  const std::atomic<bool> cancelled{true};
  const auto path = planner_->plan(grid, footprint_, {{1, 1, 0}, {70, 70, 0}, 0, &cancelled});
  ASSERT_FALSE(path);
  EXPECT_EQ(NavCode::kCancelled, path.error().code);
}

TEST_P(PlannerContract, EndsSoonWhenCancelledMeanwhile) {
  CostGrid grid = random_map(1200, 0.2, 9);  // nearly everything touches: much to search
  const Footprint wide = Footprint::circle(0.04);
  grid.at({1, 1}) = grid.at({1198, 1198}) = kFreeCost;
  std::atomic<bool> cancel{false};
  Stopwatch since;
  std::thread canceller([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    since.restart();
    cancel = true;
  });
  const auto path =
      planner_->plan(grid, wide, {pose_in(grid, {1, 1}), pose_in(grid, {1198, 1198}), 0, &cancel});
  const double late_s = since.seconds();
  canceller.join();
  if (path || path.error().code != NavCode::kCancelled) return;  // it was done before
  EXPECT_LT(late_s, 0.5);                                        // 50 ms on a machine that does nothing else
}

}  // namespace extperfc::navigate::contract
