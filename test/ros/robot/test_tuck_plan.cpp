// The paths to the tucked and the untucked pose.
#include <cmath>

#include <gtest/gtest.h>

#include "ros/robot/tuck_plan.hpp"

namespace extperfc::ros_robot {
namespace {

using simulate::ArmValues;
using simulate::Side;
using Poses = std::array<ArmValues, 2>;

Poses both(ArmValues (*pose)(Side)) {
  return {pose(Side::kLeft), pose(Side::kRight)};
}

std::vector<double> list(const ArmValues& values) {
  return {values.begin(), values.end()};
}

TEST(TuckPlan, PosesMirrorEachOther) {
  for (const auto pose : {tucked_pose, untucked_pose}) {
    const auto left = pose(Side::kLeft);
    const auto right = pose(Side::kRight);
    for (const int mirrored : {0, 2, 4, 6}) EXPECT_EQ(left[mirrored], -right[mirrored]) << mirrored;
    for (const int same : {1, 3, 5}) EXPECT_EQ(left[same], right[same]) << same;
  }
}

TEST(TuckPlan, GoesStraightBetweenTheTwo) {
  const auto goals = plan_tuck(true, both(untucked_pose), {});
  for (const Side side : simulate::kSides) {
    const auto& goal = goals[static_cast<int>(side)];
    ASSERT_EQ(goal.points.size(), 1U);
    EXPECT_EQ(goal.points[0].positions, list(tucked_pose(side)));
    EXPECT_EQ(goal.joints.front(), side == Side::kLeft ? "left_s0" : "right_s0");
    EXPECT_EQ(goal.joints.size(), 7U);
  }
  const auto back = plan_tuck(false, both(tucked_pose), {});
  ASSERT_EQ(back[0].points.size(), 1U);
  EXPECT_EQ(back[0].points[0].positions, list(untucked_pose(Side::kLeft)));
}

TEST(TuckPlan, GoesByWayOfNeutralAndUntuckedFromElsewhere) {
  const Poses elsewhere{ArmValues{0.5, 0, 0, 1, 0, 0, 0}, ArmValues{-0.5, 0, 0, 1, 0, 0, 0}};
  const auto goals = plan_tuck(true, elsewhere, {});
  ASSERT_EQ(goals[1].points.size(), 3U);
  EXPECT_EQ(goals[1].points[0].positions[5], 1.26) << "neutral";
  EXPECT_EQ(goals[1].points[1].positions, list(untucked_pose(Side::kRight)));
  EXPECT_EQ(goals[1].points[2].positions, list(tucked_pose(Side::kRight)));
  EXPECT_EQ(plan_tuck(false, elsewhere, {})[0].points.size(), 2U);
}

TEST(TuckPlan, TheArmWithTheShorterWayWaits) {
  const Poses mixed{tucked_pose(Side::kLeft), ArmValues{-0.5, 0, 0, 1, 0, 0, 0}};
  const auto goals = plan_tuck(true, mixed, {});
  ASSERT_EQ(goals[0].points.size(), 3U);
  EXPECT_EQ(goals[0].points[0].positions, list(tucked_pose(Side::kLeft)));
  EXPECT_EQ(goals[0].points[1].positions, list(tucked_pose(Side::kLeft)));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(goals[0].points[i].time_s, goals[1].points[i].time_s) << i;
}

TEST(TuckPlan, KeepsTheSpeed) {
  const TuckSpeed speed{0.6, 1.5};
  const auto goals = plan_tuck(true, both(untucked_pose), speed);
  const double distance_rad = 3.0 + 1.19;  // of e0
  EXPECT_NEAR(1.5 * distance_rad / goals[0].points[0].time_s, speed.velocity_rad_s, 1e-9);
  auto near = both(tucked_pose);
  near[0][0] += 0.1;
  const double time_s = plan_tuck(true, near, speed)[0].points[0].time_s;
  EXPECT_NEAR(6 * 0.1 / (time_s * time_s), speed.accel_rad_s2, 1e-9)
      << "a short motion is bound by acceleration";
}

}  // namespace
}  // namespace extperfc::ros_robot
