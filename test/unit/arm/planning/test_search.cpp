#include <gtest/gtest.h>

#include "arm/planning/search.hpp"
#include "test/unit/arm/planning/planar_arm.hpp"

namespace extperfc::arm {
namespace {

// Two arms of two bars each, as in planar_arm.hpp, whose bases stand 1.2 m apart on the y axis:
//
//   base_r o==== r1 ====o==== r2 ====      y = -0.6
//   base_l o==== l1 ====o==== l2 ====      y = +0.6
//
// Joints in the order r1 l1 r2 l2, so that the branches are not blocks.
CollisionModel two_arms() {
  std::string text = R"(<robot name="two"><link name="base"/>)";
  for (const std::string side : {"r", "l"})
    for (int i = 1; i <= 2; ++i) {
      const auto name = side + std::to_string(i);
      text +=
          "<link name=\"bar_" + name +
          R"("><collision><origin xyz="0.25 0 0"/><geometry><box size="0.4 0.04 0.04"/></geometry></collision></link>)";
      text += "<joint name=\"" + name + R"(" type="revolute"><parent link=")" +
              (i == 1 ? "base" : "bar_" + side + "1") + "\"/><child link=\"bar_" + name +
              "\"/><origin xyz=\"" +
              (i == 2        ? "0.5 0 0"
               : side == "r" ? "0 -0.6 0"
                             : "0 0.6 0") +
              R"("/><axis xyz="0 0 1"/><limit lower="-2.8" upper="2.8" velocity="1" effort="1"/></joint>)";
    }
  CollisionModelParams params;
  params.joints = {"r1", "l1", "r2", "l2"};
  return CollisionModel::make(RobotModel::from_urdf(text + "</robot>", ".").value(), params).value();
}

JointVector states(double r1, double l1, double r2, double l2) {
  JointVector result(4);
  result << r1, l1, r2, l2;
  return result;
}

TEST(Search, BranchesAreTheArms) {
  EXPECT_EQ(branches(two_arms()), (std::vector<JointSet>{{0, 2}, {1, 3}}));
  EXPECT_EQ(branches(planar_arm()), (std::vector<JointSet>{{0, 1, 2}}));
}

// The left arm reaches to the right and must make room before the right arm comes up: one order of the arms
// fails.
TEST(Search, FindsTheOrderOfTheArms) {
  const CollisionModel model = two_arms();
  auto checker = CollisionChecker::make(model, {}).value();
  const JointVector start = states(0, -1.3, 0, -0.2);
  const JointVector goal = states(1.3, 0.3, 0.2, 0.1);
  ASSERT_TRUE(checker.is_free(start));
  ASSERT_TRUE(checker.is_free(goal));
  ASSERT_FALSE(checker.is_free(states(1.3, -1.3, 0.2, -0.2))) << "the arms should collide";
  PlannerParams params;
  Search search(checker, model.limits(), params);
  const auto found = search.run(start, {goal}, [] { return false; });
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->waypoints.front(), start);
  EXPECT_EQ(found->waypoints.back(), goal);
  EXPECT_EQ(found->goal, 0);
  EXPECT_TRUE(free_all_along(checker, found->waypoints));
}

// Exchanging places takes both arms at once: neither can go first.
TEST(Search, MovesBothArmsAtOnceWhereNoOrderHelps) {
  const CollisionModel model = two_arms();
  auto checker = CollisionChecker::make(model, {}).value();
  const JointVector start = states(0.9, -1.9, 1.1, 0.5);
  const JointVector goal = states(1.5, -0.6, 1.5, -1.9);
  ASSERT_TRUE(checker.is_free(start));
  ASSERT_TRUE(checker.is_free(goal));
  ASSERT_FALSE(checker.is_free(states(1.5, -1.9, 1.5, 0.5)))
      << "the right arm should not be able to go first";
  ASSERT_FALSE(checker.is_free(states(0.9, -0.6, 1.1, -1.9)))
      << "the left arm should not be able to go first";
  PlannerParams params;
  Search search(checker, model.limits(), params);
  const auto found = search.run(start, {goal}, [] { return false; });
  ASSERT_TRUE(found.has_value());
  EXPECT_TRUE(free_all_along(checker, found->waypoints));
}

}  // namespace
}  // namespace extperfc::arm
