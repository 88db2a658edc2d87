// Obstacles: what marks, what clears, and what stays.
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/obstacle_layer.hpp"

namespace extperfc::navigate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr double kHeight = 0.2;

/// A grid of 10 m by 10 m about the origin, and what the layer writes into it.
class Obstacles : public testing::Test {
 protected:
  Obstacles() { use({0, 1, 10, 0.1, false}); }

  void use(const ObstacleParams& params) {
    layer = std::make_unique<ObstacleLayer>(params);
    layer->match(grid);
  }

  /// `rays` from straight ahead to the left, 0.01 rad apart.
  void scan(double stamp_s, std::vector<float> rays, const SensorParams& sensor = {},
            const Pose2& pose = {}) {
    LaserScan scan;
    scan.stamp_s = stamp_s;
    scan.angle_increment = 0.01;
    scan.range_min = 0.1;
    scan.range_max = 8;
    scan.ranges = std::move(rays);
    ASSERT_TRUE(layer->observe(scan, pose, kHeight, sensor));
  }

  Cost cost_at(double x, double y, Cost before = kFreeCost) {
    std::fill(grid.cells.begin(), grid.cells.end(), before);
    layer->write(grid, grid.box());
    return grid.at(*grid.cell_of({x, y}));
  }

  CostGrid grid = make_cost_grid(200, 200, 0.05, {-5, -5}, kFreeCost);
  std::unique_ptr<ObstacleLayer> layer;
};

TEST_F(Obstacles, KeepsWhatIsNearWhenItClearsBeyond) {
  scan(1, {1.02F, 3.02F});
  ASSERT_EQ(layer->marked_cells(), 2U);
  layer->clear_beyond({0, 0}, 2);
  EXPECT_EQ(layer->marked_cells(), 1U);
  EXPECT_EQ(cost_at(1.02, 0), kLethalCost);
  EXPECT_EQ(cost_at(3.02 * std::cos(0.01), 3.02 * std::sin(0.01)), kFreeCost);
}

TEST_F(Obstacles, ReturnMarksItsCell) {
  scan(1, {2.02F});
  EXPECT_EQ(layer->marked_cells(), 1U);
  EXPECT_EQ(cost_at(2.02, 0.01), kLethalCost);
}

TEST_F(Obstacles, RayClearsBeforeItsReturnOnly) {
  scan(1, {1.02F});
  scan(1.1, {2.02F});
  EXPECT_EQ(cost_at(1.02, 0.01), kFreeCost);
  EXPECT_EQ(cost_at(2.02, 0.01), kLethalCost);
  scan(1.2, {1.02F});
  EXPECT_EQ(cost_at(2.02, 0.01), kLethalCost);  // hidden now
}

TEST_F(Obstacles, WhatSaysNothingClearsNothing) {
  for (const float nothing : {kNan, 0.0F, -1.0F, 0.05F, -kInfinity, kInfinity, 9.0F}) {
    scan(1, {1.02F});
    scan(2, {nothing});
    EXPECT_EQ(cost_at(1.02, 0.01), kLethalCost) << nothing;
  }
}

TEST_F(Obstacles, InfinityClearsWhenAsked) {
  SensorParams sensor;
  sensor.inf_is_valid = true;
  for (const float nothing : {kInfinity, 9.0F}) {
    scan(1, {1.02F});
    scan(2, {nothing}, sensor);
    EXPECT_EQ(cost_at(1.02, 0.01), kFreeCost) << nothing;
    EXPECT_EQ(layer->marked_cells(), 0U);
  }
  scan(3, {1.02F}, sensor);
  for (const float nothing : {kNan, 0.0F, -kInfinity}) scan(4, {nothing}, sensor);
  EXPECT_EQ(cost_at(1.02, 0.01), kLethalCost);
}

TEST_F(Obstacles, RangesOfMarkingAndClearing) {
  SensorParams sensor;
  sensor.obstacle_range_m = 2;
  sensor.raytrace_range_m = 3;
  scan(1, {2.5F}, sensor);
  EXPECT_EQ(layer->marked_cells(), 0U);
  scan(1, {3.52F});
  scan(2, {4.5F}, sensor);
  EXPECT_EQ(cost_at(3.52, 0.01), kLethalCost);  // beyond the range of clearing
  scan(2, {2.82F});
  scan(3, {4.5F}, sensor);
  EXPECT_EQ(cost_at(2.82, 0.01), kFreeCost);
}

TEST_F(Obstacles, BlindSectorKeepsWhatItDoesNotSee) {
  scan(1, std::vector<float>(100, 1.5F));
  const std::size_t seen = layer->marked_cells();
  // The robot drives away and looks elsewhere for less than unseen_decay_s.
  for (int i = 0; i < 80; ++i) {
    scan(1.1 + 0.1 * i, std::vector<float>(100, 1.5F), {}, {0, 0, kPi});
    (void)layer->take_changes(grid, 1.1 + 0.1 * i);
  }
  EXPECT_EQ(layer->marked_cells(), 2 * seen);
  (void)layer->take_changes(grid, 11.5);
  EXPECT_EQ(layer->marked_cells(), seen);
}

TEST_F(Obstacles, WhatIsBesideTheScannerDoesNotAge) {
  use({0, 1, 10, 0.1, false, 1.6});
  scan(1, {1.51F});
  scan(1, {1.91F}, {}, {0, 0, kPi});
  const auto look_away = [&](double stamp_s, double x) {
    scan(stamp_s, {kNan}, {}, {x, 0, 0});
    (void)layer->take_changes(grid, stamp_s);
  };
  look_away(500, 0);
  EXPECT_EQ(cost_at(1.51, 0.01), kLethalCost);
  EXPECT_EQ(cost_at(-1.91, -0.01), kFreeCost) << "farther away";
  look_away(501, -0.2);
  EXPECT_EQ(cost_at(1.51, 0.01), kFreeCost) << "left behind";
  scan(502, {1.51F});
  scan(503, {3.0F});
  EXPECT_EQ(cost_at(1.51, 0.01), kFreeCost) << "a ray has passed";
}

/// A lidar 0.4 m above the floor that sees 0.2 rad up and down, and a table top at 0.72 m.
class ObstaclesWithHeights : public Obstacles {
 protected:
  void look(double stamp_s, float range_m, float height_m, double x) {
    LaserScan scan;
    scan.stamp_s = stamp_s;
    scan.angle_increment = 0.01;
    scan.range_min = 0.1;
    scan.range_max = 8;
    scan.ranges = {range_m};
    scan.heights_m = {height_m};
    SensorParams sensor;
    sensor.half_fov_rad = 0.2;
    ASSERT_TRUE(layer->observe(scan, {x, 0, 0}, 0.4, sensor));
    (void)layer->take_changes(grid, stamp_s);
  }
};

TEST_F(ObstaclesWithHeights, ATableThatIsTooNearToBeSeenStays) {
  look(1, 2.01F, 0.72F, 0);
  ASSERT_EQ(cost_at(2.01, 0.01), kLethalCost);
  for (double x = 0.5; x < 1.4; x += 0.05) look(1 + 2 * x, 3.0F, 0.4F, x);  // the wall behind it
  EXPECT_EQ(cost_at(2.01, 0.01), kLethalCost);
}

TEST_F(ObstaclesWithHeights, WhoWalkedPastLeavesNothingBesideTheRobot) {
  look(1, 2.01F, 0.72F, 0);
  layer->level({2.2, 0.3}, 0.3, 0.4);
  look(2, 3.0F, 0.4F, 1.4);
  EXPECT_EQ(cost_at(2.01, 0.01), kLethalCost) << "that is farther away";
  layer->level({2.2, 0.1}, 0.3, 0.4);
  look(3, 3.0F, 0.4F, 1.4);
  EXPECT_EQ(cost_at(2.01, 0.01), kFreeCost);
}

TEST_F(ObstaclesWithHeights, WhatCouldBeSeenAndIsGoneIsCleared) {
  look(1, 2.01F, 0.72F, 0);
  look(2, 3.5F, 0.4F, 0);
  EXPECT_EQ(cost_at(2.01, 0.01), kFreeCost) << "1.6 m suffice for the table's height";
  look(3, 2.01F, 0.5F, 0);
  look(4, 3.0F, 0.4F, 1.4);
  EXPECT_EQ(cost_at(2.01, 0.01), kFreeCost) << "half a metre for 0.5 m";
}

TEST_F(ObstaclesWithHeights, TheLastHeightCounts) {
  look(1, 2.01F, 1.4F, 0);
  look(2, 1.01F, 0.5F, 1);
  look(3, 3.0F, 0.4F, 1);
  EXPECT_EQ(cost_at(2.01, 0.01), kFreeCost) << "a person who was seen at 0.5 m lately, and is gone";
}

TEST_F(Obstacles, GhostBetweenRaysDecaysWhenSeen) {
  LaserScan coarse;
  coarse.stamp_s = 1;
  coarse.angle_increment = 0.2;
  coarse.range_max = 8;
  coarse.ranges = {4, 4};
  scan(1, {2.02F}, {}, {0, 0, 0.1});  // a mark just between the two rays
  ASSERT_EQ(layer->marked_cells(), 1U);
  const auto look = [&](double stamp_s) {
    coarse.stamp_s = stamp_s;
    ASSERT_TRUE(layer->observe(coarse, {0, 0, 0}, kHeight, {true, true, 1, 5}));
  };
  look(1.5);
  EXPECT_EQ(layer->marked_cells(), 1U);
  look(2.5);
  EXPECT_EQ(layer->marked_cells(), 0U);
  scan(3, {2.02F}, {}, {0, 0, 0.1});
  coarse.ranges = {4, 1.5F};  // hidden on one side
  look(6);
  coarse.ranges = {4, kNan};
  look(6);
  EXPECT_EQ(layer->marked_cells(), 1U);
}

TEST_F(Obstacles, GhostInTheGapOfAWholeRevolution) {
  LaserScan circle;
  circle.stamp_s = 5;
  circle.angle_increment = kTwoPi / 20;
  circle.range_max = 8;
  circle.ranges.assign(20, 4);
  const double gap = -kTwoPi / 40;
  scan(1, {2.02F}, {}, {0, 0, gap});
  ASSERT_TRUE(layer->observe(circle, {0, 0, 0}, kHeight, {true, true, 1, 5}));
  EXPECT_EQ(layer->marked_cells(), 0U);
  scan(1, {2.02F}, {}, {0, 0, gap});
  circle.ranges.pop_back();  // now the gap is not seen
  ASSERT_TRUE(layer->observe(circle, {0, 0, 0}, kHeight, {true, true, 1, 5}));
  EXPECT_EQ(layer->marked_cells(), 1U);
}

TEST_F(Obstacles, NewMarksAreKeptFromClearing) {
  use({0.3, 1, 10, 0.1, false});
  scan(1, {1.02F});
  scan(1.2, {2.02F});
  EXPECT_EQ(cost_at(1.02, 0.01), kLethalCost);
  scan(1.4, {2.02F});
  EXPECT_EQ(cost_at(1.02, 0.01), kFreeCost);
}

TEST_F(Obstacles, OneScanDoesNotClearItsOwnMarks) {
  // Rays side by side through the same cells, near and far.
  std::vector<float> rays;
  for (int i = 0; i < 50; ++i) rays.push_back(i % 2 == 0 ? 1.02F : 3.0F);
  scan(1, rays);
  scan(2, rays);
  EXPECT_EQ(cost_at(1.02, 0.01), kLethalCost);
}

TEST_F(Obstacles, ClockSetBackLeavesNoGhostAndLosesNothing) {
  scan(1000, {1.02F});
  (void)layer->take_changes(grid, 5);
  EXPECT_EQ(layer->marked_cells(), 1U);
  (void)layer->take_changes(grid, 14.9);
  EXPECT_EQ(layer->marked_cells(), 1U);
  (void)layer->take_changes(grid, 15.1);
  EXPECT_EQ(layer->marked_cells(), 0U);
}

TEST_F(Obstacles, FreesUnknownCellsThatRaysPassed) {
  use({0, 1, 10, 0.1, true});
  scan(1, {2.02F});
  EXPECT_EQ(cost_at(1, 0.01, kUnknownCost), kFreeCost);
  EXPECT_EQ(cost_at(2.5, 0.01, kUnknownCost), kUnknownCost);
  EXPECT_EQ(cost_at(1, 0.01, kLethalCost), kLethalCost);  // of the map
  use({0, 1, 10, 0.1, false});
  scan(1, {2.02F});
  EXPECT_EQ(cost_at(1, 0.01, kUnknownCost), kUnknownCost);
}

TEST_F(Obstacles, RefusesWhatCannotBe) {
  EXPECT_THROW(ObstacleLayer({0, 1, 10, 0.1, false, -1}), std::invalid_argument);
  SensorParams wide;
  wide.half_fov_rad = 1.6;
  LaserScan any;
  any.angle_increment = 0.1;
  any.range_max = 5;
  any.ranges = {1};
  EXPECT_FALSE(layer->observe(any, {}, kHeight, wide));
  LaserScan scan;
  EXPECT_FALSE(layer->observe(scan, {}, kHeight, {}));
  scan.angle_increment = 0.1;
  scan.range_max = 5;
  scan.ranges = {1};
  EXPECT_FALSE(layer->observe(scan, {0, std::nan(""), 0}, kHeight, {}));
  EXPECT_FALSE(layer->observe(scan, {}, std::nan(""), {}));
  EXPECT_TRUE(layer->observe(scan, {}, kHeight, {}));
  PointObservation cloud;
  cloud.sensor_m.x() = std::nan("");
  EXPECT_FALSE(layer->observe(cloud, {}));
  EXPECT_THROW(ObstacleLayer({-1, 1, 1, 0, false}), std::invalid_argument);
  EXPECT_THROW(ObstacleLayer({2, 1, 1, 0, false}), std::invalid_argument);
  EXPECT_THROW(ObstacleLayer({0, 1, std::nan(""), 0, false}), std::invalid_argument);
}

TEST_F(Obstacles, SensorOutsideTheGridStillSeesIn) {
  scan(1, {2.02F}, {}, {-6, 0, 0});
  EXPECT_EQ(cost_at(-3.98, 0.01), kLethalCost);
  scan(2, {3.02F}, {}, {-6, 0, 0});
  EXPECT_EQ(cost_at(-3.98, 0.01), kFreeCost);
  scan(3, {3.0F}, {}, {-60, 0, 0});
  EXPECT_EQ(layer->marked_cells(), 1U);
}

TEST_F(Obstacles, PointsMarkWithinTheirBandOfHeight) {
  PointObservation cloud;
  cloud.stamp_s = 1;
  cloud.sensor_m = {0, 0, 1};
  cloud.points_m = {
      {1.02F, 0, 0.01F}, {1.52F, 0, 0.3F}, {2.02F, 0, 1.59F}, {2.52F, 0, 1.7F}, {kNan, 0, 0.3F}};
  ASSERT_TRUE(layer->observe(cloud, {}));
  EXPECT_EQ(layer->marked_cells(), 2U);
  EXPECT_EQ(cost_at(1.52, 0.01), kLethalCost);
  EXPECT_EQ(cost_at(2.02, 0.01), kLethalCost);
}

TEST_F(Obstacles, RayAboveAnObstacleDoesNotClearIt) {
  const auto see = [&](double stamp_s, double sensor_z, const Eigen::Vector3f& point_m) {
    PointObservation cloud;
    cloud.stamp_s = stamp_s;
    cloud.sensor_m = {0, 0, sensor_z};
    cloud.points_m = {point_m};
    ASSERT_TRUE(layer->observe(cloud, {}));
  };
  see(1, 1, {1.52F, 0, 0.3F});
  see(2, 1, {3, 0, 0.9F});  // passes 0.6 m above
  EXPECT_EQ(cost_at(1.52, 0.01), kLethalCost);
  see(3, 1, {1.82F, 0, 0.16F});  // through where it was
  EXPECT_EQ(cost_at(1.52, 0.01), kFreeCost);
  // A table: a ray below its plate.
  see(4, 1, {1.52F, 0, 0.7F});
  see(5, 0.2, {3, 0, 0.2F});
  EXPECT_EQ(cost_at(1.52, 0.01), kLethalCost);
}

TEST_F(Obstacles, FootprintIsCleared) {
  std::vector<float> rays(629, 0.3F);
  scan(1, rays);
  scan(1, std::vector<float>(629, 1.0F));
  const std::size_t both = layer->marked_cells();
  layer->clear_footprint(Footprint::circle(0.5), {0, 0, 0.1});
  EXPECT_LT(layer->marked_cells(), both);
  EXPECT_EQ(cost_at(0.3, 0.01), kFreeCost);
  EXPECT_EQ(cost_at(1.0, 0.01), kLethalCost);
  const CellBox box = layer->take_changes(grid, 1);
  EXPECT_LE(box.min.column, 80);
}

TEST_F(Obstacles, WhereTheRobotStandsIsFreeThoughNoRayReachesIt) {
  use({0, 1, 10, 0.1, true});
  (void)layer->take_changes(grid, 0);
  layer->clear_footprint(Footprint::circle(0.5), {1, 0, 0});
  EXPECT_EQ(cost_at(1.3, 0.01, kUnknownCost), kFreeCost);
  EXPECT_EQ(cost_at(1.7, 0.01, kUnknownCost), kUnknownCost);
  EXPECT_EQ(cost_at(1.3, 0.01, kLethalCost), kLethalCost) << "of the map";
  EXPECT_LE(layer->take_changes(grid, 1).min.column, 111);
  use({0, 1, 10, 0.1, false});
  layer->clear_footprint(Footprint::circle(0.5), {1, 0, 0});
  EXPECT_EQ(cost_at(1.3, 0.01, kUnknownCost), kUnknownCost);
}

TEST_F(Obstacles, DirectionsLoseNoCellThatARayPasses) {
  // Against a layer that traces every ray, since it frees unknown cells.
  Rng rng(7);
  ObstacleLayer all({0, 1, 10, 0.1, true});
  all.match(grid);
  for (int round = 0; round < 300; ++round) {
    LaserScan scan;
    scan.stamp_s = 0.05 * round;
    scan.angle_min = rng.uniform(-3, 3);
    scan.angle_increment = rng.chance(0.5) ? 0.013 : -0.013;
    scan.range_max = 6;
    for (int i = 0; i < 400; ++i) scan.ranges.push_back(static_cast<float>(rng.uniform(0.02, 5)));
    const Pose2 pose{rng.uniform(-5.2, 5.2), rng.uniform(-5.2, 5.2), rng.uniform(-kPi, kPi)};
    ASSERT_TRUE(layer->observe(scan, pose, kHeight, {}));
    ASSERT_TRUE(all.observe(scan, pose, kHeight, {}));
    ASSERT_EQ(layer->marked_cells(), all.marked_cells()) << "round " << round;
    CostGrid a = grid, b = grid;
    layer->write(a, a.box());
    all.write(b, b.box());
    ASSERT_EQ(a.cells == b.cells, true) << "round " << round;
  }
}

TEST_F(Obstacles, RaysPassEveryCellOnTheirPath) {
  // Sampled densely: each cell with a part of the ray longer than a few steps is freed.
  use({0, 1, 10, 0.1, true});
  Rng rng(8);
  for (int round = 0; round < 300; ++round) {
    layer->clear();
    const Pose2 pose{rng.uniform(-4, 4), rng.uniform(-4, 4), rng.uniform(-kPi, kPi)};
    const double range_m = rng.uniform(0.2, 3.9);
    scan(1, {static_cast<float>(range_m)}, {}, pose);
    std::fill(grid.cells.begin(), grid.cells.end(), kUnknownCost);
    layer->write(grid, grid.box());
    std::set<std::size_t> passed;
    int samples = 0, last = -1;
    for (int i = 0; i < 20000; ++i) {
      const double r = range_m * i / 20000;
      const auto cell = grid.cell_of({pose.x + r * std::cos(pose.yaw), pose.y + r * std::sin(pose.yaw)});
      if (!cell) break;
      const auto index = static_cast<int>(grid.index(*cell));
      samples = index == last ? samples + 1 : 0;
      last = index;
      if (samples == 3) passed.insert(grid.index(*cell));
    }
    for (const std::size_t index : passed) EXPECT_NE(grid.cells[index], kUnknownCost) << "round " << round;
    const auto freed = std::count(grid.cells.begin(), grid.cells.end(), kFreeCost);
    EXPECT_LE(static_cast<std::size_t>(freed), passed.size() + 4) << "round " << round;
  }
}

}  // namespace
}  // namespace extperfc::navigate
