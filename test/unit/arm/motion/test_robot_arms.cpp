// Groups, limits and states of a robot, and what is wrong with some.
#include <regex>
#include <string>

#include <gtest/gtest.h>

#include "test/unit/arm/motion/baxter_arms.hpp"

namespace extperfc::arm {
namespace {

/// Two links, one joint between them with the given inside.
Result<RobotArms> tiny(const std::string& joint) {
  const auto robot = RobotModel::from_urdf(
      "<robot name='tiny'><link name='root'/><link name='tip'/>" + joint + "</robot>", {});
  if (!robot) return tl::unexpected(robot.error());
  const auto srdf = parse_srdf(
      "<robot name='tiny'><group name='arm'><chain base_link='root' tip_link='tip'/></group></robot>");
  return RobotArms::make(*robot, srdf.value());
}

std::string revolute(const std::string& limit) {
  return "<joint name='a' type='revolute'><parent link='root'/><child link='tip'/><axis xyz='0 0 1'/>" +
         limit + "</joint>";
}

TEST(RobotArms, KnowsBaxtersGroups) {
  const auto& arms = test::baxter_arms();
  const auto both = arms.group("both_arms");
  ASSERT_TRUE(both);
  EXPECT_EQ((*both)->joints.size(), 14U);
  EXPECT_EQ((*both)->tips, (std::vector<std::string>{"left_gripper", "right_gripper"}));
  const auto left = arms.group("left_arm");
  ASSERT_TRUE(left);
  EXPECT_EQ((*left)->tips, std::vector<std::string>{"left_gripper"});
  EXPECT_DOUBLE_EQ((*left)->max_velocity[0], 1.5);
  EXPECT_DOUBLE_EQ((*left)->max_velocity[6], 4.0);
}

TEST(RobotArms, NamesWhatThereIsWhereANameIsWrong) {
  const auto& arms = test::baxter_arms();
  const auto none = arms.group("third_arm");
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("both_arms"), std::string::npos) << none.error().message;
  const auto state = arms.named_state(**arms.group("left_arm"), "yoga");
  ASSERT_FALSE(state);
  EXPECT_NE(state.error().message.find("neutral, tuck, untuck"), std::string::npos) << state.error().message;
}

TEST(RobotArms, StatesOfBothArmsAreJoined) {
  const auto& arms = test::baxter_arms();
  const auto tuck = arms.named_state(**arms.group("both_arms"), "tuck");
  ASSERT_TRUE(tuck) << tuck.error().message;
  EXPECT_EQ(tuck->size(), 14U);
  EXPECT_DOUBLE_EQ(tuck->at("left_s0"), -1.0);
  EXPECT_DOUBLE_EQ(tuck->at("right_s0"), 1.0);
  // Where the manufacturer's kinematics put the tucked grippers, in the frame `base`.
  const auto root_T_base = arms.link_pose("base", *tuck).value();
  const Pose base_T_left = root_T_base.inverse() * arms.link_pose("left_gripper", *tuck).value();
  EXPECT_LT((base_T_left.translation() - Eigen::Vector3d(-0.134718, 0.371985, -0.070326)).norm(), 1e-5);
}

TEST(RobotArms, RefusesJointsWithoutLimits) {
  EXPECT_TRUE(tiny(revolute("<limit lower='-1' upper='1' velocity='2' effort='1'/>")));
  const auto still = tiny(revolute("<limit lower='-1' upper='1' velocity='0' effort='1'/>"));
  ASSERT_FALSE(still);
  EXPECT_NE(still.error().message.find("joint a has no velocity limit"), std::string::npos);
  const auto stuck = tiny(revolute("<limit lower='1' upper='1' velocity='2' effort='1'/>"));
  ASSERT_FALSE(stuck);
  EXPECT_NE(stuck.error().message.find("cannot move"), std::string::npos) << stuck.error().message;
  const auto missing = tiny(revolute(""));
  ASSERT_FALSE(missing);
  EXPECT_FALSE(missing.error().message.empty());
}

TEST(RobotArms, RefusesALoop) {
  const auto loop = RobotModel::from_urdf(
      "<robot name='loop'><link name='root'/><link name='x'/><link name='y'/>"
      "<joint name='a' type='fixed'><parent link='x'/><child link='y'/></joint>"
      "<joint name='b' type='fixed'><parent link='y'/><child link='x'/></joint></robot>",
      {});
  ASSERT_FALSE(loop);
  EXPECT_FALSE(loop.error().message.empty());
}

TEST(RobotArms, RefusesAccelerationsOfJointsThatAreNotThere) {
  const auto& known = test::baxter_arms();
  RobotArmsParams params;
  params.max_acceleration["left_s9"] = 1.0;
  EXPECT_FALSE(RobotArms::make(known.robot(), known.srdf(), params));
  params.max_acceleration.clear();
  params.default_max_acceleration = 0.0;
  EXPECT_FALSE(RobotArms::make(known.robot(), known.srdf(), params));
}

}  // namespace
}  // namespace extperfc::arm
