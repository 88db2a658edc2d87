#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/simulate/floor_plan.hpp"

namespace extperfc::simulate {
namespace {

/// A plan of 4 x 4 m with one shape on the floor at the middle, away from the robot.
WorldSpec world_with(const Geometry& geometry, const Pose& pose, Mobility mobility = Mobility::kFixed) {
  WorldSpec world;
  world.min_m = {-2, -2};
  world.max_m = {2, 2};
  world.robot_start = {-1.9, -1.9, 0};
  BodySpec body;
  body.name = "object";
  body.mobility = mobility;
  body.world_T_body = pose;
  body.shapes.push_back({geometry, Pose::Identity(), {}});
  world.bodies.push_back(body);
  return world;
}

FloorPlan plan_of(const WorldSpec& world, double resolution, double low = 0.1, double high = 1) {
  const auto plan = floor_plan(world, resolution, low, high);
  EXPECT_TRUE(plan) << plan.error().message;
  return plan.value_or(FloorPlan{});
}

double occupied_area(const FloorPlan& plan) {
  int cells = 0;
  for (const auto value : plan.data) cells += value == kOccupiedCell ? 1 : 0;
  return cells * plan.resolution_m * plan.resolution_m;
}

/// Cells that a convex outline touches: its area, and a band of its perimeter around it. The band is at most
/// one diagonal wide.
void expect_area(const FloorPlan& plan, double area, double perimeter) {
  EXPECT_GE(occupied_area(plan), area * 0.999);
  EXPECT_LE(occupied_area(plan), area + perimeter * plan.resolution_m * std::sqrt(2.0));
}

TEST(FloorPlan, AlignedBoxIsExact) {
  const FloorPlan plan = plan_of(world_with(Box{{0.4, 0.6, 1}}, make_pose({0.3, 0.2, 0.5})), 0.05);
  EXPECT_EQ(plan.width, 80);
  EXPECT_EQ(plan.height, 80);
  EXPECT_EQ(plan.origin_m, Eigen::Vector2d(-2, -2));
  EXPECT_NEAR(occupied_area(plan), 0.24, 1e-9) << "a border that lies on cells' borders adds none";
  for (int row = 0; row < plan.height; ++row)
    for (int column = 0; column < plan.width; ++column) {
      const double x = -2 + (column + 0.5) * 0.05;
      const double y = -2 + (row + 0.5) * 0.05;
      const bool inside = std::abs(x - 0.3) < 0.2 && std::abs(y - 0.2) < 0.3;
      EXPECT_EQ(plan.at(column, row), inside ? kOccupiedCell : kFreeCell) << x << ' ' << y;
    }
}

TEST(FloorPlan, TurnedAndRoundShapesHaveTheirArea) {
  expect_area(plan_of(world_with(Box{{0.8, 0.5, 1}}, make_pose({0, 0, 0.5}, {0, 0, 0.4})), 0.02), 0.4, 2.6);
  expect_area(plan_of(world_with(Cylinder{0.5, 1}, make_pose({0, 0, 0.5})), 0.02), kPi * 0.25, kPi);
  expect_area(plan_of(world_with(Cylinder{0.2, 1}, make_pose({0, 0, 0.3}, {kPi / 2, 0, 0.7})), 0.02), 0.4,
              2.8);
}

TEST(FloorPlan, CountsOnlyWhatLiesBetweenTheHeights) {
  // A sphere of 0.5 m around z = 0.5: its disc at 0.9 m has a radius of 0.3 m.
  const WorldSpec ball = world_with(Sphere{0.5}, make_pose({0, 0, 0.5}));
  expect_area(plan_of(ball, 0.02, 0.9, 2), kPi * 0.09, 2 * kPi * 0.3);
  expect_area(plan_of(ball, 0.02, 0.1, 2), kPi * 0.25, 2 * kPi * 0.5);
  // A cone of 1 m with a base of 0.5 m: 0.2 m wide at 0.6 m.
  const WorldSpec cone = world_with(Cone{0.5, 1}, make_pose({0, 0, 0.5}));
  expect_area(plan_of(cone, 0.02, 0.6, 2), kPi * 0.04, 2 * kPi * 0.2);
  // A tilted board.
  const WorldSpec board = world_with(Box{{2, 0.4, 0.02}}, make_pose({0, 0, 1}, {0, kPi / 4, 0}));
  expect_area(plan_of(board, 0.02, 0.8, 1.0), 0.4 * 0.228, 1.3);
  EXPECT_EQ(occupied_area(plan_of(ball, 0.02, 1.001, 2)), 0);
}

TEST(FloorPlan, MovableObjectsCountAndLooseOnesDoNot) {
  const Box box{{0.4, 0.4, 1}};
  const Pose pose = make_pose({0, 0, 0.5});
  EXPECT_GT(occupied_area(plan_of(world_with(box, pose, Mobility::kMovable), 0.05)), 0.1);
  EXPECT_EQ(occupied_area(plan_of(world_with(box, pose, Mobility::kLoose), 0.05)), 0);
}

TEST(FloorPlan, WhatCannotBeReachedIsUnknownUnlessADoorLeadsThere) {
  const char* const room = R"(
name: rooms
floor_plan: {min: [-3, -2], max: [3, 2]}
robot: {at: [-2, 0]}
objects:
  - wall: {closed: true, thickness: 0.1, path: [[-2.95, -1.95], [2.95, -1.95], [2.95, 1.95], [-2.95, 1.95]]}
  - wall: {path: [[0, -1.9], [0, 1.9]], thickness: 0.1)";
  const auto shut = parse_world(std::string(room) + "}\n", "shut");
  const auto door = parse_world(std::string(room) + ", openings: [{at: [0, 0], door: {}}]}\n", "door");
  ASSERT_TRUE(shut && door);
  const FloorPlan without = plan_of(*shut, 0.05);
  const FloorPlan with = plan_of(*door, 0.05);
  EXPECT_EQ(without.at(20, 40), kFreeCell);
  EXPECT_EQ(without.at(100, 40), kUnknownCell);
  EXPECT_EQ(with.at(100, 40), kFreeCell);
  EXPECT_EQ(with.at(60, 40), kOccupiedCell) << "the door itself";
  EXPECT_NEAR(occupied_area(without), 2 * 6 * 0.1 + 2 * 3.8 * 0.1 + 3.8 * 0.1, 0.45) << "walls and skirting";
}

TEST(FloorPlan, RefusesWhatCannotBe) {
  const WorldSpec world = world_with(Sphere{0.5}, Pose::Identity());
  EXPECT_FALSE(floor_plan(world, 0, 0, 1));
  EXPECT_FALSE(floor_plan(world, std::nan(""), 0, 1));
  EXPECT_FALSE(floor_plan(world, 0.05, 1, 1));
  WorldSpec large = world;
  large.max_m = {1e4, 1e4};
  EXPECT_FALSE(floor_plan(large, 0.05, 0, 1));
}

}  // namespace
}  // namespace extperfc::simulate
