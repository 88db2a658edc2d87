#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "mapping/map_renderer.hpp"
#include "test/support/planar_world.hpp"

namespace extperfc::mapping {
namespace {

constexpr std::size_t kUnbounded = std::numeric_limits<std::size_t>::max();
constexpr double kResolutionM = 0.05;
constexpr double kOccupied = 0.25;

std::int8_t at(const OccupancyGrid& map, double x, double y) {
  const auto cell = map.cell_of(x, y);
  return cell ? map.at(cell->column, cell->row) : OccupancyGrid::kUnknown;
}

/// True when both say the same of every place; what lies outside of a map is unknown to it.
void expect_same(const OccupancyGrid& a, const OccupancyGrid& b) {
  std::size_t different = 0;
  for (const auto* one : {&a, &b}) {
    const auto& other = one == &a ? b : a;
    for (std::size_t row = 0; row < one->height; ++row)
      for (std::size_t column = 0; column < one->width; ++column) {
        const Pose2 middle = one->middle_of({column, row});
        if (one->at(column, row) != at(other, middle.x, middle.y)) ++different;
      }
  }
  EXPECT_EQ(different, 0U);
}

std::size_t count(const OccupancyGrid& map, std::int8_t value) {
  return static_cast<std::size_t>(std::count(map.cells.begin(), map.cells.end(), value));
}

KeyFrame see_room(const Pose2& pose, Rng& rng) {
  const PlanarScanner scanner;
  static const PlanarWorld kRoom = planar_room();
  KeyFrame frame;
  frame.points = scan_points(scanner.scan(kRoom, pose, rng), {});
  return frame;
}

class MapRendererTest : public testing::Test {
 protected:
  void see(const std::vector<Pose2>& poses) {
    for (const Pose2& pose : poses) {
      frames_.push_back(see_room(pose, rng_));
      poses_.push_back(pose);
    }
  }
  std::shared_ptr<const OccupancyGrid> draw_from_scratch(const std::vector<Pose2>& poses) {
    MapRenderer renderer(kResolutionM, kOccupied);
    EXPECT_TRUE(renderer.update(frames_, poses, kUnbounded));
    return renderer.map();
  }

  Rng rng_{1};
  std::vector<KeyFrame> frames_;
  std::vector<Pose2> poses_;
};

TEST_F(MapRendererTest, WallsAreOccupiedTheRoomFreeAndOutsideUnknown) {
  see({{-3, -1.5, 0}, {0, 0, 1}, {2, 0, 2}, {-1, 1, -2}});
  const auto map = draw_from_scratch(poses_);
  int wall = 0;
  int tried = 0;
  for (double x = -3.9; x < -1.6; x += 0.05, ++tried)
    if (at(*map, x, -3.0) == OccupancyGrid::kOccupied || at(*map, x, -3.04) == OccupancyGrid::kOccupied)
      ++wall;
  EXPECT_GT(wall, 0.9 * tried);
  for (double x = -3.4; x < 2.5; x += 0.1)
    for (double y = -1.9; y < 1.4; y += 0.1) EXPECT_EQ(at(*map, x, y), OccupancyGrid::kFree) << x << " " << y;
  for (double x = -6; x < 6; x += 0.1)
    for (const double y : {-3.3, 3.3}) EXPECT_EQ(at(*map, x, y), OccupancyGrid::kUnknown);
  for (double y = -3; y < 3; y += 0.1)
    for (const double x : {-4.3, 4.3}) EXPECT_EQ(at(*map, x, y), OccupancyGrid::kUnknown);
  EXPECT_EQ(at(*map, -3.3, 2.4), OccupancyGrid::kUnknown) << "inside the cupboard";
  EXPECT_EQ(count(*map, OccupancyGrid::kFree) + count(*map, OccupancyGrid::kOccupied) +
                count(*map, OccupancyGrid::kUnknown),
            map->cells.size());
}

TEST_F(MapRendererTest, OriginIsTheLowerLeftCorner) {
  KeyFrame frame;
  frame.points.surface.push_back({{1.0F, -0.73F}, {-1, 0}});
  MapRenderer renderer(0.1, kOccupied);
  EXPECT_TRUE(renderer.map()->empty());
  ASSERT_TRUE(renderer.update({frame}, {{10, 20, 0}}, kUnbounded));
  const auto map = renderer.map();
  EXPECT_EQ(map->resolution_m, 0.1);
  EXPECT_EQ(map->origin.yaw, 0);
  EXPECT_EQ(map->cells.size(), map->width * map->height);
  EXPECT_EQ(count(*map, OccupancyGrid::kOccupied), 1U);
  EXPECT_EQ(at(*map, 11.05, 19.25), OccupancyGrid::kOccupied);
  EXPECT_EQ(at(*map, 10.05, 20.05), OccupancyGrid::kFree);
  EXPECT_LE(map->origin.x, 10);
  EXPECT_LE(map->origin.y, 19.2 + 1e-9);
}

TEST_F(MapRendererTest, ClearRaysMakeFreeAndNoWall) {
  KeyFrame frame;
  frame.points.clear.emplace_back(2.0F, 0.02F);
  MapRenderer renderer(kResolutionM, kOccupied);
  ASSERT_TRUE(renderer.update({frame}, {{0, 0, 0}}, kUnbounded));
  const auto map = renderer.map();
  EXPECT_EQ(count(*map, OccupancyGrid::kOccupied), 0U);
  for (double x = 0.02; x < 1.98; x += 0.05) EXPECT_EQ(at(*map, x, 0.02), OccupancyGrid::kFree) << x;
  EXPECT_EQ(at(*map, 2.1, 0.02), OccupancyGrid::kUnknown);
}

TEST_F(MapRendererTest, OccupiedFromTheFractionOnThatWasAsked) {
  KeyFrame hit;
  hit.points.surface.push_back({{1.02F, 0.02F}, {-1, 0}});
  KeyFrame through;
  through.points.surface.push_back({{2.02F, 0.02F}, {-1, 0}});
  for (const auto& [threshold, expected] :
       {std::pair{0.2, OccupancyGrid::kOccupied}, std::pair{0.3, OccupancyGrid::kFree}}) {
    MapRenderer renderer(kResolutionM, threshold);
    ASSERT_TRUE(renderer.update({hit, through, through, through}, std::vector<Pose2>(4), kUnbounded));
    EXPECT_EQ(at(*renderer.map(), 1.02, 0.02), expected) << "a quarter of the rays ended there";
  }
}

TEST_F(MapRendererTest, MovedIsTheSameAsDrawnThere) {
  for (int round = 0; round < 5; ++round) see({{-3, -1.5, 0.1 * round}, {0, 0, 1}, {2, 0, 2}, {-1, 1, -2}});
  MapRenderer renderer(kResolutionM, kOccupied);
  ASSERT_TRUE(renderer.update(frames_, poses_, kUnbounded));
  for (int round = 0; round < 4; ++round) {
    auto moved = poses_;
    for (Pose2& pose : moved)
      if (rng_.chance(0.7))
        pose = compose(pose, {rng_.uniform(0.1, 5), rng_.uniform(-2, 2), rng_.uniform(-1, 1)});
    ASSERT_TRUE(renderer.update(frames_, moved, kUnbounded));
    expect_same(*renderer.map(), *draw_from_scratch(moved));
  }
  ASSERT_TRUE(renderer.update(frames_, poses_, kUnbounded));
  expect_same(*renderer.map(), *draw_from_scratch(poses_));
}

TEST_F(MapRendererTest, AllTakenAwayLeavesAnEmptyMap) {
  see({{-3, -1.5, 0}, {0, 0, 1}});
  MapRenderer renderer(kResolutionM, kOccupied);
  ASSERT_TRUE(renderer.update(frames_, poses_, kUnbounded));
  ASSERT_TRUE(renderer.update(frames_, {{40, 0, 0}, {40, 0, 0}}, kUnbounded));
  const auto map = renderer.map();
  for (double x = -5; x < 5; x += 0.05)
    for (double y = -4; y < 4; y += 0.05) ASSERT_EQ(at(*map, x, y), OccupancyGrid::kUnknown);
  EXPECT_EQ(at(*map, 40.5, 0), OccupancyGrid::kFree);
}

TEST_F(MapRendererTest, WhatWasTakenAwayNeedsNoMemory) {
  see({{-3, -1.5, 0}, {0, 0, 1}, {2, 0, 2}});
  MapRenderer renderer(kResolutionM, kOccupied);
  ASSERT_TRUE(renderer.update(frames_, poses_, kUnbounded));
  const std::size_t here = renderer.counts_size();
  ASSERT_GT(here, 0U);
  auto elsewhere = poses_;
  for (Pose2& pose : elsewhere) pose.x += 64;  // whole tiles
  ASSERT_TRUE(renderer.update(frames_, elsewhere, kUnbounded));
  EXPECT_EQ(renderer.counts_size(), here);
  (void)renderer.map();
  ASSERT_TRUE(renderer.update(frames_, poses_, kUnbounded));
  EXPECT_EQ(renderer.counts_size(), here);
  expect_same(*renderer.map(), *draw_from_scratch(poses_));
}

TEST_F(MapRendererTest, ALongStandIsTakenBackExactly) {
  see({{0, 0, 0}});
  const std::size_t rays = frames_[0].points.surface.size();
  ASSERT_GT(rays, 150U);
  // Parked with a key frame a second: the scanner's own cell counts more rays than 16 bits do.
  const std::size_t parked = 70000 / rays;
  frames_.resize(parked + 1, frames_[0]);
  poses_.resize(parked + 1, poses_[0]);
  MapRenderer renderer(kResolutionM, kOccupied);
  ASSERT_TRUE(renderer.update(frames_, poses_, kUnbounded));
  for (std::size_t i = 0; i < parked; ++i) poses_[i].x += 30;  // a loop was closed: all but the last one move
  ASSERT_TRUE(renderer.update(frames_, poses_, kUnbounded));
  EXPECT_EQ(at(*renderer.map(), 0.02, 0.02), OccupancyGrid::kFree);
  expect_same(*renderer.map(), *draw_from_scratch(poses_));
}

TEST_F(MapRendererTest, BudgetIsRespected) {
  see({{-3, -1.5, 0}, {0, 0, 1}, {2, 0, 2}, {-1, 1, -2}, {1, 1, 1}});
  MapRenderer renderer(kResolutionM, kOccupied);
  std::size_t calls = 1;
  while (!renderer.update(frames_, poses_, 1)) {
    ++calls;
    ASSERT_LE(calls, frames_.size()) << "a key frame a call at least";
    (void)renderer.map();
  }
  EXPECT_EQ(calls, frames_.size()) << "and at most, when a key frame alone exceeds the budget";
  expect_same(*renderer.map(), *draw_from_scratch(poses_));
  EXPECT_TRUE(renderer.update(frames_, poses_, 0)) << "nothing is left to do";
  auto moved = poses_;
  for (Pose2& pose : moved) pose.x += 1;
  EXPECT_FALSE(renderer.update(frames_, moved, 0));
  expect_same(*renderer.map(), *draw_from_scratch(poses_));
  while (!renderer.update(frames_, moved, 1)) {
  }
  expect_same(*renderer.map(), *draw_from_scratch(moved));
}

TEST_F(MapRendererTest, GrowsInAllDirections) {
  const std::vector<Pose2> directions{{0, 0, 0},   {30, 0, 0},    {-30, 0, 0}, {0, 30, 0},
                                      {0, -30, 0}, {-45, -45, 0}, {50, 50, 0}};
  MapRenderer renderer(kResolutionM, kOccupied);
  for (const Pose2& corner : directions) {
    frames_.push_back(see_room({0, 0, 0}, rng_));
    poses_.push_back(corner);
    ASSERT_TRUE(renderer.update(frames_, poses_, kUnbounded));
    const auto map = renderer.map();
    for (const Pose2& pose : poses_) EXPECT_EQ(at(*map, pose.x + 0.5, pose.y), OccupancyGrid::kFree);
  }
  expect_same(*renderer.map(), *draw_from_scratch(poses_));
}

TEST_F(MapRendererTest, BoundsOfACallAreMadeUpForByMoreCalls) {
  see({{0, 0, 0}});
  MapRenderer renderer(kResolutionM, kOccupied);
  ASSERT_TRUE(renderer.update(frames_, poses_, kUnbounded));
  const auto first = renderer.map();
  const std::size_t first_cells = first->cells.size();
  for (const Pose2& away : {Pose2{40, 20, 1}, Pose2{-30, 50, 2}}) {
    frames_.push_back(see_room({0, 0, 0}, rng_));
    poses_.push_back(away);
  }
  ASSERT_TRUE(renderer.update(frames_, poses_, kUnbounded));
  const auto expected = draw_from_scratch(poses_);
  const std::size_t copied_cells = expected->cells.size() / 10;
  std::size_t calls = 0;
  std::size_t calls_until_grown = 0;
  for (bool grown = false; calls == 0 || !renderer.complete(); ++calls) {
    ASSERT_LT(calls, 200U);
    const auto map = renderer.map({1, copied_cells});
    grown = grown || map->cells.size() != first_cells;
    EXPECT_EQ(map->cells.size(), grown ? expected->cells.size() : first_cells);
    if (!grown) ++calls_until_grown;
  }
  EXPECT_GE(calls_until_grown, 8U) << "ten, but for whole rows";
  EXPECT_GT(calls, calls_until_grown + 10) << "a tile a call";
  EXPECT_EQ(renderer.map()->cells, expected->cells);
  EXPECT_EQ(first->cells.size(), first_cells) << "held all the time";
}

TEST_F(MapRendererTest, MapsThatAreHeldStayAsTheyWere) {
  MapRenderer renderer(kResolutionM, kOccupied);
  std::vector<std::shared_ptr<const OccupancyGrid>> held;
  std::vector<std::vector<std::int8_t>> cells;
  for (int i = 0; i < 6; ++i) {
    see({{2.0 * i, 0.3 * i, 0.5 * i}});
    ASSERT_TRUE(renderer.update(frames_, poses_, kUnbounded));
    held.push_back(renderer.map());
    cells.push_back(held.back()->cells);
    if (i > 0) {
      EXPECT_NE(cells[cells.size() - 1], cells[cells.size() - 2]);
    }
  }
  for (std::size_t i = 0; i < held.size(); ++i) EXPECT_EQ(held[i]->cells, cells[i]) << i;
}

TEST_F(MapRendererTest, SmallMovesAreNotDrawnAgain) {
  see({{0, 0, 0}});
  MapRenderer renderer(kResolutionM, kOccupied);
  ASSERT_TRUE(renderer.update(frames_, poses_, kUnbounded));
  const auto before = renderer.map();
  EXPECT_TRUE(renderer.update(frames_, {{0.01, 0.01, 0.001}}, 0));
  EXPECT_EQ(renderer.map()->cells, before->cells);
  for (int i = 0; i < 10; ++i)  // creeping adds up
    EXPECT_TRUE(renderer.update(frames_, {{0.01 * i, 0, 0}}, kUnbounded));
  const auto crept = renderer.map();
  EXPECT_NE(crept->cells, before->cells);
}

TEST_F(MapRendererTest, WhatCannotBeIsNotDrawn) {
  see({{0, 0, 0}});
  MapRenderer renderer(kResolutionM, kOccupied);
  EXPECT_TRUE(renderer.update(frames_, {{1e12, 0, 0}}, kUnbounded));
  EXPECT_TRUE(renderer.map()->empty());
  EXPECT_TRUE(renderer.update(frames_, poses_, kUnbounded));
  EXPECT_EQ(at(*renderer.map(), 0.5, 0), OccupancyGrid::kFree);
}

}  // namespace
}  // namespace extperfc::mapping
