#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "extperfc/navigate/map_explanation.hpp"

namespace extperfc::navigate {
namespace {

/// 4 m x 4 m from (0, 0), with one occupied cell around (2.05, 2.05).
OccupancyGrid map_with_a_post() {
  OccupancyGrid map;
  map.width = map.height = 40;
  map.resolution_m = 0.1;
  map.cells.assign(map.width * map.height, OccupancyGrid::kFree);
  map.cells[20 * map.width + 20] = OccupancyGrid::kOccupied;
  return map;
}

TEST(MapExplanation, WithoutAMapNothingIsExplained) {
  EXPECT_FALSE(MapExplanation().explains({2.05, 2.05}, 0));
}

TEST(MapExplanation, ExplainsWhatIsWithinTheMarginAlongEachAxis) {
  MapExplanation explanation;
  explanation.set_map(map_with_a_post(), 0.2);
  for (const Eigen::Vector2d& near : {Eigen::Vector2d(2.05, 2.05), {2.25, 2.25}, {1.85, 2.05}, {2.05, 1.81}})
    EXPECT_TRUE(explanation.explains(near, 0)) << near.transpose();
  for (const Eigen::Vector2d& far : {Eigen::Vector2d(2.35, 2.05), {2.05, 1.75}, {-1, 2}, {9, 9}})
    EXPECT_FALSE(explanation.explains(far, 0)) << far.transpose();
}

TEST(MapExplanation, TheMarginGrowsWithTheRange) {
  MapExplanation explanation;
  explanation.set_map(map_with_a_post(), 0.1);
  EXPECT_FALSE(explanation.explains({2.35, 2.05}, 0));
  EXPECT_TRUE(explanation.explains({2.35, 2.05}, 5)) << "two degrees are 0.17 m there";
  EXPECT_FALSE(explanation.explains({2.55, 2.05}, 5));
}

TEST(MapExplanation, TakesExplainedReturnsOutOfAScan) {
  MapExplanation explanation;
  explanation.set_map(map_with_a_post(), 0.0);
  LaserScan scan;
  scan.angle_increment = 0.5;
  scan.range_min = 0.1;
  scan.range_max = 8;
  scan.ranges = {1.05F, 1.05F, std::numeric_limits<float>::infinity(), 0.05F};
  const LaserScan rest = explanation.unexplained(scan, {1, 2.05, 0});
  EXPECT_TRUE(std::isnan(rest.ranges[0]));  // the post
  EXPECT_EQ(1.05F, rest.ranges[1]);
  EXPECT_TRUE(std::isinf(rest.ranges[2]));
  EXPECT_EQ(0.05F, rest.ranges[3]);
}

TEST(MapHistory, TheOldMapDoesNotShowWhoHasJustCome) {
  OccupancyGrid empty = map_with_a_post();
  std::fill(empty.cells.begin(), empty.cells.end(), OccupancyGrid::kFree);
  MapHistory history(3);
  EXPECT_FALSE(history.newest().explains({2.05, 2.05}, 0));
  EXPECT_FALSE(history.old().explains({2.05, 2.05}, 0));
  EXPECT_FALSE(history.old_stamp_s());
  history.add(empty, 0.1, 10);
  history.add(map_with_a_post(), 0.1, 12);
  EXPECT_TRUE(history.newest().explains({2.05, 2.05}, 0));
  EXPECT_FALSE(history.old().explains({2.05, 2.05}, 0));
  EXPECT_EQ(10, history.old_stamp_s());
  history.add(map_with_a_post(), 0.1, 15);  // the one of 12 s is old now
  EXPECT_TRUE(history.old().explains({2.05, 2.05}, 0));
  EXPECT_EQ(12, history.old_stamp_s());
}

TEST(MapHistory, BeginsAnewWhenTheClockIsSetBackAndKeepsFewMaps) {
  MapHistory history(3);
  history.add(map_with_a_post(), 0.1, 10);
  history.add(map_with_a_post(), 0.1, 2);
  EXPECT_EQ(2, history.old_stamp_s());
  for (int i = 1; i <= 100; ++i) history.add(map_with_a_post(), 0.1, 2 + 0.1 * i);
  EXPECT_LE(*history.old_stamp_s(), 12 - 3);
}

}  // namespace
}  // namespace extperfc::navigate
