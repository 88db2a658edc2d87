// Chains from a robot description: what they hold, forward kinematics, Jacobian.
#include <gtest/gtest.h>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "test/unit/arm/kinematics/arms.hpp"

namespace extperfc::arm {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

/// base -- slide (along y) --> a -- turn (about -z, endless) --> b -- fixed --> tool
std::string mixed_joints() {
  return link("base") + link("a") + link("b") + link("tool") +
         joint("slide", "prismatic", "base", "a",
               origin("1 0 0.5", "0.3 0 0") + "<axis xyz='0 2 0'/>" + limit(-0.5, 0.25)) +
         joint("turn", "continuous", "a", "b", origin("0 0.2 0", "0 0.4 1") + "<axis xyz='0 0 -1'/>") +
         joint("hand", "fixed", "b", "tool", origin("0.3 0 0.1", "0 0 0.7"));
}

ErrorCode error_of(const RobotModel& robot, const std::string& root, const std::string& tip) {
  const auto chain = ArmChain::make(robot, root, tip);
  EXPECT_FALSE(chain);
  return chain ? ErrorCode::kFailed : chain.error().code;
}

RobotModel robot_of(const std::string& xml) {
  return RobotModel::from_urdf("<robot name='small'>" + xml + "</robot>", ".").value();
}

TEST(ArmChain, HasBaxtersSevenJoints) {
  const ArmChain chain = baxter_arm("left");
  const std::vector<std::string> names{"left_s0", "left_s1", "left_e0", "left_e1",
                                       "left_w0", "left_w1", "left_w2"};
  EXPECT_EQ(chain.joint_names(), names);
  EXPECT_EQ(chain.root_link(), "base");
  EXPECT_EQ(chain.tip_link(), "left_gripper");
  EXPECT_DOUBLE_EQ(chain.limits().lower[3], -0.05);
  EXPECT_DOUBLE_EQ(chain.limits().upper[3], 2.618);
  EXPECT_DOUBLE_EQ(chain.max_velocity()[0], 1.5);
  EXPECT_DOUBLE_EQ(chain.max_velocity()[6], 4.0);
  for (std::size_t i = 0; i < names.size(); ++i)
    EXPECT_EQ(baxter().joints()[chain.robot_joints()[i]].name, names[i]);
  EXPECT_EQ(chain.kdl().getNrOfJoints(), 7u);
}

TEST(ArmChain, MayStartAtTheMobileBase) {
  const auto chain = ArmChain::make(baxter(), "base_link", "right_hand");
  ASSERT_TRUE(chain) << chain.error().message;
  EXPECT_EQ(chain->joint_count(), 7);
}

TEST(ArmChain, HandlesSlidingAndEndlessJoints) {
  const ArmChain chain = chain_of(mixed_joints(), "tool");
  EXPECT_EQ(chain.limits().lower[1], -kInf);
  EXPECT_EQ(chain.limits().upper[1], kInf);
  EXPECT_DOUBLE_EQ(chain.mid_range()[0], -0.125);
  EXPECT_DOUBLE_EQ(chain.mid_range()[1], 0);
  JointVector q(2);
  q << 1, 100;
  EXPECT_FALSE(chain.within_limits(q));
  EXPECT_TRUE(chain.within_limits(chain.clamp(q)));
  EXPECT_DOUBLE_EQ(chain.clamp(q)[1], 100);
  JointVector from(2);
  from << 0.5, 100 - 2 * 6.283185307179586 - 0.25;
  const JointVector delta = chain.difference(q, from);
  EXPECT_DOUBLE_EQ(delta[0], 0.5);
  EXPECT_NEAR(delta[1], 0.25, 1e-12);
}

TEST(ArmChain, NamesWhatIsWrong) {
  EXPECT_EQ(error_of(baxter(), "ghost", "left_gripper"), ErrorCode::kNotFound);
  EXPECT_EQ(error_of(baxter(), "base", "ghost"), ErrorCode::kNotFound);
  EXPECT_EQ(error_of(baxter(), "left_gripper", "base"), ErrorCode::kInvalidArgument);
  EXPECT_EQ(error_of(baxter(), "right_hand", "left_hand"), ErrorCode::kInvalidArgument);
  EXPECT_EQ(error_of(baxter(), "base", "base"), ErrorCode::kInvalidArgument);
  EXPECT_EQ(error_of(baxter(), "base", "torso"), ErrorCode::kInvalidArgument);
  const auto missing = ArmChain::make(baxter(), "base", "ghost");
  EXPECT_NE(missing.error().message.find("'ghost'"), std::string::npos);
}

TEST(ArmChain, RefusesJointsThatFollowOthersOrHaveNoRange) {
  const std::string two = link("base") + link("a") + link("b") +
                          joint("first", "revolute", "base", "a", "<axis xyz='0 0 1'/>" + limit(-1, 1));
  EXPECT_EQ(error_of(robot_of(two + joint("second", "revolute", "a", "b",
                                          "<axis xyz='0 0 1'/>" + limit(-1, 1) + "<mimic joint='first'/>")),
                     "base", "b"),
            ErrorCode::kUnsupported);
  EXPECT_EQ(
      error_of(robot_of(two + joint("second", "revolute", "a", "b", "<axis xyz='0 0 1'/>" + limit(0, 0))),
               "base", "b"),
      ErrorCode::kInvalidArgument);
}

TEST(ArmChain, HoldsAsManyJointsAsAVector) {
  std::string xml = link("l0");
  for (int i = 0; i < kMaxJoints + 1; ++i)
    xml += link("l" + std::to_string(i + 1)) +
           joint("j" + std::to_string(i), "revolute", "l" + std::to_string(i), "l" + std::to_string(i + 1),
                 origin("0.1 0 0") + "<axis xyz='0 1 1'/>" + limit(-1, 1));
  const RobotModel robot = robot_of(xml);
  EXPECT_TRUE(ArmChain::make(robot, "l0", "l" + std::to_string(kMaxJoints)));
  EXPECT_EQ(error_of(robot, "l0", "l" + std::to_string(kMaxJoints + 1)), ErrorCode::kUnsupported);
}

TEST(ArmChain, RefusesVectorsOfAnotherSize) {
  const ArmChain chain = baxter_arm("left");
  EXPECT_THROW((void)chain.forward(JointVector::Zero(6)), std::invalid_argument);
  EXPECT_THROW((void)chain.jacobian(JointVector::Zero(8)), std::invalid_argument);
}

/// Six, seven and another number of joints are compiled apart.
std::vector<ArmChain> chains() {
  return {baxter_arm("left"), baxter_arm("right"),
          ArmChain::make(baxter(), "base_link", "right_lower_forearm").value(),
          ArmChain::make(baxter(), "left_upper_shoulder", "left_wrist").value(),
          chain_of(mixed_joints(), "tool")};
}

TEST(ForwardKinematics, AgreesWithKdl) {
  Rng rng(1);
  for (const ArmChain& chain : chains()) {
    KDL::ChainFkSolverPos_recursive position(chain.kdl());
    KDL::ChainJntToJacSolver velocity(chain.kdl());
    for (int i = 0; i < 200; ++i) {
      const JointVector q = random_joints(chain, rng);
      KDL::Frame frame;
      ASSERT_GE(position.JntToCart(to_kdl(q), frame), 0);
      EXPECT_LT((from_kdl(frame).matrix() - chain.forward(q).matrix()).cwiseAbs().maxCoeff(), 1e-12);
      KDL::Jacobian jacobian(static_cast<unsigned>(chain.joint_count()));
      ASSERT_GE(velocity.JntToJac(to_kdl(q), jacobian), 0);
      EXPECT_LT((jacobian.data - chain.jacobian(q)).cwiseAbs().maxCoeff(), 1e-12);
    }
  }
}

TEST(ForwardKinematics, AgreesWithTheRobotModel) {
  Rng rng(2);
  const auto all = chains();
  for (std::size_t c = 0; c + 1 < all.size(); ++c)
    for (int i = 0; i < 50; ++i) {
      const JointVector q = random_joints(all[c], rng);
      std::vector<double> positions(baxter().joints().size(), 0.0);
      for (int j = 0; j < all[c].joint_count(); ++j) positions[all[c].robot_joints()[j]] = q[j];
      const auto poses = baxter().link_poses(positions);
      const Pose root_T_tip =
          poses[*baxter().link(all[c].root_link())].inverse() * poses[*baxter().link(all[c].tip_link())];
      EXPECT_LT((root_T_tip.matrix() - all[c].forward(q).matrix()).cwiseAbs().maxCoeff(), 1e-12);
    }
}

/// Central differences: their error is of the order step^2 and rounding / step, both below 1e-8 here.
TEST(Jacobian, AgreesWithDifferences) {
  constexpr double kStep = 1e-6;
  Rng rng(3);
  for (const ArmChain& chain : chains())
    for (int i = 0; i < 50; ++i) {
      const JointVector q = random_joints(chain, rng);
      const Jacobian jacobian = chain.jacobian(q);
      for (int j = 0; j < chain.joint_count(); ++j) {
        JointVector change = JointVector::Zero(q.size());
        change[j] = kStep;
        const Pose before = chain.forward(q - change);
        const Pose after = chain.forward(q + change);
        const Eigen::Vector3d linear = (after.translation() - before.translation()) / (2 * kStep);
        const Eigen::Matrix3d spin =
            (after.linear() - before.linear()) / (2 * kStep) * chain.forward(q).linear().transpose();
        EXPECT_LT((linear - jacobian.col(j).head<3>()).norm(), 1e-8);
        EXPECT_LT((Eigen::Vector3d(spin(2, 1), spin(0, 2), spin(1, 0)) - jacobian.col(j).tail<3>()).norm(),
                  1e-8);
      }
    }
}

TEST(Kdl, FramesAndJointsConvertBackAndForth) {
  Rng rng(4);
  const ArmChain chain = baxter_arm("left");
  const JointVector q = random_joints(chain, rng);
  EXPECT_EQ(from_kdl(to_kdl(q)), q);
  const Pose pose = chain.forward(q);
  EXPECT_EQ(from_kdl(to_kdl(pose)).matrix(), pose.matrix());
  EXPECT_THROW((void)from_kdl(KDL::JntArray(kMaxJoints + 1)), std::invalid_argument);
}

}  // namespace
}  // namespace extperfc::arm
