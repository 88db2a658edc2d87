// Objects that cannot be where the robot is.
#include <limits>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/robot_overlap.hpp"
#include "extperfc/base/rng.hpp"

#include "test/unit/arm/perception/depth_scene.hpp"

namespace extperfc::arm {
namespace {

using test::both_arms;
using test::reaching;

Shape shape_at(const Geometry& geometry, const Pose& root_T_shape) {
  Shape shape;
  shape.geometry = geometry;
  shape.body_T_shape = root_T_shape;
  return shape;
}

Pose hand() {
  return both_arms().link_pose(reaching(), "left_gripper_base").value();
}

bool overlaps(const Geometry& geometry, const Pose& root_T_shape) {
  return robot_overlaps(both_arms(), reaching(), {shape_at(geometry, root_T_shape)}).at(0);
}

TEST(RobotOverlap, KnowsWhatIsInTheHandFromWhatIsInFrontOfIt) {
  const std::vector<Geometry> kinds{Box{{0.05, 0.05, 0.05}}, Sphere{0.025}, Cylinder{0.025, 0.05},
                                    Cone{0.03, 0.09}};
  for (const auto& kind : kinds) {
    EXPECT_TRUE(overlaps(kind, hand()));
    EXPECT_FALSE(overlaps(kind, hand() * make_pose({0.0, 0.0, 0.4}, {0.0, 0.0, 0.0})));
    EXPECT_FALSE(overlaps(kind, make_pose({1.5, 0.0, 2.0}, {0.0, 0.0, 0.0})));
  }
  EXPECT_TRUE(overlaps(Box{{1.0, 1.0, 1.0}}, hand())) << "larger than the hand";
}

TEST(RobotOverlap, TheCornersOfABoxAreNoneOfABall) {
  // The hand is in a corner of the box about the ball.
  const Pose pose = hand() * make_pose({0.25, 0.25, 0.25}, {0.0, 0.0, 0.0});
  EXPECT_TRUE(overlaps(Box{{0.6, 0.6, 0.6}}, pose));
  EXPECT_FALSE(overlaps(Sphere{0.3}, pose));
}

TEST(RobotOverlap, EachShapeHasItsOwnAnswer) {
  const Geometry cube = Box{{0.05, 0.05, 0.05}};
  const Pose far = make_pose({1.5, 0.0, 2.0}, {0.0, 0.0, 0.0});
  const auto found = robot_overlaps(both_arms(), reaching(),
                                    {shape_at(cube, far), shape_at(cube, hand()), shape_at(cube, far)});
  EXPECT_EQ(found, (std::vector<bool>{false, true, false}));
  EXPECT_TRUE(robot_overlaps(both_arms(), reaching(), {}).empty());
}

TEST(RobotOverlap, WhatIsNoShapeOverlapsNothing) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(overlaps(Sphere{0.0}, hand()));
  EXPECT_FALSE(overlaps(Box{{0.05, -0.05, 0.05}}, hand()));
  EXPECT_FALSE(overlaps(Box{{kNan, 0.05, 0.05}}, hand()));
}

TEST(RobotOverlap, WhatItSaysOverlapsIsACollision) {
  Rng rng(8);
  int overlapping = 0;
  for (int round = 0; round < 400; ++round) {
    const Pose pose =
        hand() * make_pose({rng.uniform(-0.15, 0.15), rng.uniform(-0.15, 0.15), rng.uniform(-0.2, 0.3)},
                           {rng.uniform(-3, 3), rng.uniform(-3, 3), rng.uniform(-3, 3)});
    const double size = rng.uniform(0.02, 0.1);
    const std::vector<Geometry> kinds{Box{{size, size, size}}, Sphere{size / 2}, Cylinder{size / 2, size},
                                      Cone{size / 2, size}};
    const auto& kind = kinds[static_cast<std::size_t>(round % 4)];
    CollisionWorld world;
    ASSERT_TRUE(world.add({"object", {shape_at(kind, pose)}, Pose::Identity()}));
    auto checker = CollisionChecker::make(both_arms(), world);
    ASSERT_TRUE(checker);
    if (!overlaps(kind, pose)) continue;
    ++overlapping;
    EXPECT_FALSE(checker->is_free(reaching())) << "round " << round;
  }
  EXPECT_GT(overlapping, 50);
  EXPECT_LT(overlapping, 350);
}

}  // namespace
}  // namespace extperfc::arm
