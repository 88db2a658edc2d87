// From requests to trajectories with Baxter before a table; Bullet looks at what comes out.
#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "test/unit/arm/motion/baxter_arms.hpp"

namespace extperfc::arm {
namespace {

constexpr double kTableTop = 0.62;  // [m]

class Pipeline : public testing::Test {
 protected:
  MotionRequest request(const std::string& group) const {
    MotionRequest made;
    made.group = group;
    made.start = test::standing("untuck");
    made.goal = NamedState{"neutral"};
    return made;
  }

  /// A pose of the left gripper that looks down.
  static ToolTarget down(const Eigen::Vector3d& at, const std::string& link = "left_gripper") {
    ToolTarget target;
    target.link = link;
    target.root_T_tool = make_pose(at, {M_PI, 0.0, 0.0});
    return target;
  }

  /// Bullet, every 0.002 rad of the motion as a controller interpolates it (the fastest joint moves less).
  void expect_free(const MotionRequest& request, const MotionOutcome& outcome, const CollisionWorld& world) {
    auto exact = pipeline_.checker(request.group, request.start, world, false);
    ASSERT_TRUE(exact);
    const auto& trajectory = *outcome.trajectory;
    JointVector last = trajectory.sample(0.0).position;
    for (double t = 0.0; t <= trajectory.duration_s() + 1e-3; t += 1e-3) {
      const JointVector now = trajectory.sample(t).position;
      if ((now - last).norm() < 0.002 && t > 0.0) continue;
      last = now;
      const auto contact = exact->contact(now);
      ASSERT_FALSE(contact) << contact->first << " touches " << contact->second << " after " << t << " s";
    }
  }

  void expect_limits(const MotionOutcome& outcome, double velocity_scale) {
    const auto& group = **test::baxter_arms().group("left_arm");
    const auto& trajectory = *outcome.trajectory;
    for (double t = 0.0; t <= trajectory.duration_s(); t += 1e-3) {
      const auto sample = trajectory.sample(t);
      for (Eigen::Index j = 0; j < sample.velocity.size(); ++j)
        ASSERT_LE(std::abs(sample.velocity[j]), velocity_scale * group.max_velocity[j % 7] * (1 + 1e-9));
    }
  }

  MotionPipeline pipeline_{test::baxter_arms(), {}};
  CollisionWorld world_{test::table_world(kTableTop)};
};

TEST_F(Pipeline, MovesToANamedState) {
  auto asked = request("both_arms");
  asked.velocity_scale = 0.5;
  const auto outcome = pipeline_.plan(asked, world_);
  ASSERT_EQ(outcome.code, ArmCode::kSuccess) << outcome.message;
  EXPECT_EQ(outcome.joints.size(), 14U);
  EXPECT_DOUBLE_EQ(outcome.fraction, 1.0);
  const auto goal = RobotArms::select(**test::baxter_arms().group("both_arms"), test::standing("neutral"));
  EXPECT_LT((outcome.points.back().position - *goal).norm(), 1e-9);
  expect_limits(outcome, 0.5);
  expect_free(asked, outcome, world_);
}

TEST_F(Pipeline, BringsATool) {
  auto asked = request("left_arm");
  asked.goal = std::vector<ToolTarget>{down({0.75, 0.25, kTableTop + 0.15})};
  const auto outcome = pipeline_.plan(asked, world_);
  ASSERT_EQ(outcome.code, ArmCode::kSuccess) << outcome.message;
  auto end = asked.start;
  for (std::size_t i = 0; i < outcome.joints.size(); ++i)
    end[outcome.joints[i]] = outcome.points.back().position[static_cast<Eigen::Index>(i)];
  const Pose reached = test::baxter_arms().link_pose("left_gripper", end).value();
  EXPECT_LT((reached.translation() - Eigen::Vector3d(0.75, 0.25, kTableTop + 0.15)).norm(), 2e-4);
  expect_free(asked, outcome, world_);
}

// "Anywhere here, looking down, turned as you like": the middle of the region is inside a crate.
TEST_F(Pipeline, ReachesARegion) {
  const Eigen::Vector3d middle(0.75, 0.25, kTableTop + 0.1);
  auto world = world_;
  Shape crate;
  crate.geometry = Box{{0.16, 0.16, 0.3}};
  ASSERT_TRUE(world.add({"crate", {crate}, make_pose(middle)}));
  auto asked = request("left_arm");
  asked.goal = std::vector<ToolTarget>{down(middle)};
  EXPECT_EQ(pipeline_.plan(asked, world).code, ArmCode::kGoalInCollision);

  auto region = down(middle);
  region.tolerance.position_m = {0.25, 0.25, 0.05};
  region.tolerance.orientation_rad = {0.1, 0.1, std::numeric_limits<double>::infinity()};
  asked.goal = std::vector<ToolTarget>{region};
  const auto outcome = pipeline_.plan(asked, world);
  ASSERT_EQ(outcome.code, ArmCode::kSuccess) << outcome.message;
  auto end = asked.start;
  for (std::size_t i = 0; i < outcome.joints.size(); ++i)
    end[outcome.joints[i]] = outcome.points.back().position[static_cast<Eigen::Index>(i)];
  const Pose off = region.root_T_tool.inverse() * test::baxter_arms().link_pose("left_gripper", end).value();
  EXPECT_TRUE((off.translation().cwiseAbs().array() <= region.tolerance.position_m.array()).all())
      << off.translation().transpose();
  EXPECT_GT(off.linear()(2, 2), std::cos(0.15)) << "it does not look down";
  expect_free(asked, outcome, world);
}

TEST_F(Pipeline, BringsBothToolsAtOnce) {
  auto asked = request("both_arms");
  asked.goal = std::vector<ToolTarget>{down({0.75, 0.2, kTableTop + 0.15}),
                                       down({0.75, -0.2, kTableTop + 0.15}, "right_gripper")};
  const auto outcome = pipeline_.plan(asked, world_);
  ASSERT_EQ(outcome.code, ArmCode::kSuccess) << outcome.message;
  expect_free(asked, outcome, world_);
}

TEST_F(Pipeline, ManyRandomGoalsNeverCollide) {
  auto asked = request("left_arm");
  Rng rng(7);
  for (int i = 0; i < 12; ++i) {
    asked.seed = static_cast<std::uint64_t>(i + 1);
    asked.goal = std::vector<ToolTarget>{down(
        Eigen::Vector3d(rng.uniform(0.62, 0.78), rng.uniform(0.0, 0.5), kTableTop + rng.uniform(0.05, 0.3)))};
    const auto outcome = pipeline_.plan(asked, world_);
    ASSERT_EQ(outcome.code, ArmCode::kSuccess) << outcome.message;
    expect_free(asked, outcome, world_);
    if (HasFatalFailure()) return;
  }
}

TEST_F(Pipeline, SameSeedSameTrajectory) {
  auto asked = request("left_arm");
  asked.goal = std::vector<ToolTarget>{down({0.8, 0.1, kTableTop + 0.1})};
  const auto one = pipeline_.plan(asked, world_);
  const auto two = MotionPipeline(test::baxter_arms(), {}).plan(asked, world_);
  ASSERT_EQ(one.code, ArmCode::kSuccess) << one.message;
  ASSERT_EQ(one.points.size(), two.points.size());
  for (std::size_t i = 0; i < one.points.size(); ++i) {
    EXPECT_EQ(one.points[i].time_s, two.points[i].time_s);
    EXPECT_EQ(one.points[i].position, two.points[i].position);
  }
}

TEST_F(Pipeline, SaysWhyThereIsNoPath) {
  const auto code = [&](MotionRequest asked) {
    asked.planning_time_s = 1.0;
    const auto outcome = pipeline_.plan(asked, world_);
    EXPECT_FALSE(outcome.message.empty());
    EXPECT_FALSE(outcome.trajectory);
    return outcome.code;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  auto asked = request("left_arm");
  asked.goal = std::vector<ToolTarget>{down({3.0, 0.0, 1.0})};
  EXPECT_EQ(code(asked), ArmCode::kGoalUnreachable);
  asked.goal = std::vector<ToolTarget>{down({0.8, 0.2, kTableTop - 0.02})};
  EXPECT_EQ(code(asked), ArmCode::kGoalInCollision);
  asked.goal = std::vector<ToolTarget>{down({nan, 0.2, 1.0})};
  EXPECT_EQ(code(asked), ArmCode::kInvalidRequest);
  asked.goal = JointPositions{{"left_s0", nan}};
  EXPECT_EQ(code(asked), ArmCode::kInvalidRequest);
  asked.goal = JointPositions{{"left_s0", 2.5}};
  EXPECT_EQ(code(asked), ArmCode::kGoalOutsideLimits);
  asked.goal = JointPositions{{"right_s0", 0.0}};
  EXPECT_EQ(code(asked), ArmCode::kInvalidRequest);
  asked.goal = std::vector<ToolTarget>{down({0.8, 0.2, 1.0}, "right_gripper")};
  EXPECT_EQ(code(asked), ArmCode::kInvalidRequest);
  asked.goal = std::vector<ToolTarget>{down({0.8, 0.2, 0.9}), down({0.8, 0.3, 0.9})};
  EXPECT_EQ(code(asked), ArmCode::kInvalidRequest);
  asked.goal = std::vector<ToolTarget>{};
  EXPECT_EQ(code(asked), ArmCode::kInvalidRequest);
  asked.goal = NamedState{"yoga"};
  EXPECT_EQ(code(asked), ArmCode::kInvalidRequest);
  asked = request("left_arm");
  asked.start.erase("left_e0");
  EXPECT_EQ(code(asked), ArmCode::kNoJointStates);
  asked = request("left_arm");
  asked.velocity_scale = 0.0;
  EXPECT_EQ(code(asked), ArmCode::kInvalidRequest);
  asked = request("left_arm");
  asked.planner = "crystal_ball";
  EXPECT_EQ(code(asked), ArmCode::kInvalidRequest);
  asked = request("left_arm");
  asked.cancelled = [] { return true; };
  asked.goal = std::vector<ToolTarget>{down({0.8, 0.2, 0.9})};
  EXPECT_EQ(code(asked), ArmCode::kCancelled);
}

TEST_F(Pipeline, StartInCollisionIsNamed) {
  auto asked = request("left_arm");
  Shape block;
  block.geometry = Box{{0.2, 0.2, 0.2}};
  const Pose hand = test::baxter_arms().link_pose("left_gripper", asked.start).value();
  ASSERT_TRUE(world_.add({"block", {block}, make_pose(hand.translation())}));
  const auto outcome = pipeline_.plan(asked, world_);
  EXPECT_EQ(outcome.code, ArmCode::kStartInCollision);
  EXPECT_NE(outcome.message.find("block"), std::string::npos) << outcome.message;
}

/// 1 mm beside a finger: nearer than plans keep. The arm gets away all the same, and hits nothing.
TEST_F(Pipeline, StartsBesideAnObject) {
  auto asked = request("left_arm");
  asked.start = test::standing("neutral");
  asked.goal = NamedState{"untuck"};
  auto free = pipeline_.checker("left_arm", asked.start, world_, false);
  const auto start = RobotArms::select(**test::baxter_arms().group("left_arm"), asked.start);
  const Pose hand = test::baxter_arms().link_pose("left_gripper", asked.start).value();
  Shape plate;
  plate.geometry = Box{{0.3, 0.3, 0.01}};
  Pose below = hand;
  for (double gap = 0.0; gap < 0.1; gap += 0.0005) {
    below = hand * make_pose({0.0, 0.0, 0.005 + gap});
    ASSERT_TRUE(world_.add({"plate", {plate}, below}));
    free = pipeline_.checker("left_arm", asked.start, world_, false);
    if (free->is_free(*start)) break;
  }
  ASSERT_TRUE(free->is_free(*start));
  EXPECT_FALSE(pipeline_.checker("left_arm", asked.start, world_, true)->is_free(*start));
  const auto outcome = pipeline_.plan(asked, world_);
  ASSERT_EQ(outcome.code, ArmCode::kSuccess) << outcome.message;
  expect_free(asked, outcome, world_);
}

TEST_F(Pipeline, TheOtherArmStandsWhereItIs) {
  auto asked = request("left_arm");
  asked.goal = std::vector<ToolTarget>{down({0.75, -0.1, kTableTop + 0.2})};
  const auto first = pipeline_.plan(asked, world_);
  ASSERT_EQ(first.code, ArmCode::kSuccess) << first.message;
  // The right arm goes to where the left one shall go.
  auto right = request("right_arm");
  right.goal = std::vector<ToolTarget>{down({0.75, -0.1, kTableTop + 0.2}, "right_gripper")};
  const auto other = pipeline_.plan(right, world_);
  ASSERT_EQ(other.code, ArmCode::kSuccess) << other.message;
  for (std::size_t i = 0; i < other.joints.size(); ++i)
    asked.start[other.joints[i]] = other.points.back().position[static_cast<Eigen::Index>(i)];
  const auto blocked = pipeline_.plan(asked, world_);
  EXPECT_EQ(blocked.code, ArmCode::kGoalInCollision) << blocked.message;
}

}  // namespace
}  // namespace extperfc::arm
