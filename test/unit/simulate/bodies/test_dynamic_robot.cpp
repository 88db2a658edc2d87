#include "test/unit/simulate/bodies/baxter_arm.hpp"

namespace extperfc::simulate {
namespace {

const int kFinger = joint_index("l_gripper_l_finger_joint");
const int kOtherFinger = joint_index("l_gripper_r_finger_joint");

void hold(Bodies& bodies, const std::vector<double>& positions) {
  for (std::size_t i = 0; i < positions.size(); ++i)
    bodies.set_target(static_cast<int>(i), {Drive::kPosition, positions[i], 0, 0, 0});
}

TEST(DynamicRobot, StartsAtRestWhereItIsPut) {
  const auto start = untucked();
  const auto bodies = make_bodies(WorldSpec{}, mobile_baxter(), start, true);
  hold(*bodies, start);
  step(*bodies, 1);
  const auto poses = mobile_baxter().link_poses(start);
  for (int i = 0; i < static_cast<int>(poses.size()); ++i)
    EXPECT_LT((bodies->world_T_link(i).translation() - poses[i].translation()).norm(), 1e-3)
        << mobile_baxter().links()[i].name;
}

TEST(DynamicRobot, TracksASine) {
  const auto start = untucked();
  const auto bodies = make_bodies(WorldSpec{}, mobile_baxter(), start, true);
  auto before = start;
  double squares = 0;
  int count = 0;
  for (int i = 1; i <= 240 * 6; ++i) {
    const double t = i * kStep;
    auto next = start;
    for (const char* side : {"left", "right"}) {
      const auto joints = arm_joints(side);
      for (int k = 0; k < 7; ++k) {
        const Joint& joint = mobile_baxter().joints()[joints[k]];
        const double wave = std::min(1.0, t) * 0.35 * std::sin(2 * M_PI * 0.25 * t + k);
        next[joints[k]] = std::clamp(start[joints[k]] + wave, joint.lower, joint.upper);
        bodies->set_target(joints[k], {Drive::kPosition, next[joints[k]],
                                       (next[joints[k]] - before[joints[k]]) / kStep, 0, 0});
      }
    }
    before = next;
    bodies->step();
    for (const int joint : arm_joints("left")) {
      const double error = bodies->position(joint) - next[joint];
      squares += t > 1 ? error * error : 0;
      count += t > 1 ? 1 : 0;
    }
  }
  EXPECT_LT(std::sqrt(squares / count), 0.002);
}

TEST(DynamicRobot, MotorsHoldTheArmWithTheEffortOfGravity) {
  const auto start = untucked();
  const auto bodies = make_bodies(WorldSpec{}, mobile_baxter(), start, true);
  hold(*bodies, start);
  step(*bodies, 1);
  const auto gravity = bodies->gravity_efforts();
  for (const int joint : arm_joints("left"))
    EXPECT_NEAR(bodies->effort(joint), gravity[joint], 0.05) << mobile_baxter().joints()[joint].name;
}

/// Stretched to the front: of the given poses the one with the largest efforts.
TEST(DynamicRobot, MotorsCarryTheArmsInThePoseNeutral) {
  auto neutral = untucked();
  const std::array<double, 7> values{0, -0.55, 0, 0.75, 0, 1.26, 0};
  for (const char* side : {"left", "right"})
    for (int i = 0; i < 7; ++i) neutral[arm_joints(side)[i]] = values[i];
  const auto bodies = make_bodies(WorldSpec{}, mobile_baxter(), neutral, true);
  hold(*bodies, neutral);
  step(*bodies, 3);
  for (const char* side : {"left", "right"})
    for (const int joint : arm_joints(side))
      EXPECT_NEAR(bodies->position(joint), neutral[joint], 0.002) << mobile_baxter().joints()[joint].name;
}

TEST(DynamicRobot, EffortOfGravityHoldsTheArmWithoutMotors) {
  const auto start = untucked();
  const auto bodies = make_bodies(WorldSpec{}, mobile_baxter(), start, true);
  hold(*bodies, start);
  step(*bodies, 0.1);
  for (int i = 0; i < 480; ++i) {
    const auto gravity = bodies->gravity_efforts();
    for (const int joint : arm_joints("left"))
      bodies->set_target(joint, {Drive::kEffort, 0, 0, gravity[joint], 0});
    bodies->step();
  }
  for (const int joint : arm_joints("left"))
    EXPECT_NEAR(bodies->position(joint), start[joint], 0.02) << mobile_baxter().joints()[joint].name;
}

TEST(DynamicRobot, EffortMovesAJointUpToItsLimit) {
  const auto start = untucked();
  const auto bodies = make_bodies(WorldSpec{}, mobile_baxter(), start, true);
  hold(*bodies, start);
  const int wrist = joint_index("left_w2");
  for (int i = 0; i < 480; ++i) {
    bodies->set_target(wrist, {Drive::kEffort, 0, 0, 0.5, 0});
    bodies->step();
    ASSERT_LT(bodies->position(wrist), mobile_baxter().joints()[wrist].upper + 0.1);
  }
  EXPECT_NEAR(bodies->position(wrist), mobile_baxter().joints()[wrist].upper, 0.02);
  EXPECT_DOUBLE_EQ(bodies->effort(wrist), 0.5);
}

TEST(DynamicRobot, WeakMotorsLetTheArmSink) {
  const auto start = untucked();
  const auto bodies = make_bodies(WorldSpec{}, mobile_baxter(), start, true);
  hold(*bodies, start);
  const int shoulder = joint_index("left_s1");
  bodies->set_target(shoulder, {Drive::kPosition, start[shoulder], 0, 0, 2});
  step(*bodies, 0.5);
  EXPECT_GT(bodies->position(shoulder), start[shoulder] + 0.1);
  EXPECT_LE(std::abs(bodies->effort(shoulder)), 2 + 1e-9);
}

TEST(DynamicRobot, VelocityIsKept) {
  const auto start = untucked();
  const auto bodies = make_bodies(WorldSpec{}, mobile_baxter(), start, true);
  hold(*bodies, start);
  const int shoulder = joint_index("left_s0");
  bodies->set_target(shoulder, {Drive::kVelocity, 0, 0.4, 0, 0});
  step(*bodies, 1);
  EXPECT_NEAR(bodies->velocity(shoulder), 0.4, 0.01);
  EXPECT_NEAR(bodies->position(shoulder), start[shoulder] + 0.4, 0.02);
}

TEST(DynamicRobot, FarTargetIsReachedAtTheJointsSpeed) {
  const auto start = untucked();
  const auto bodies = make_bodies(WorldSpec{}, mobile_baxter(), start, true);
  hold(*bodies, start);
  const int shoulder = joint_index("left_s0");
  bodies->set_target(shoulder, {Drive::kPosition, start[shoulder] + 1, 0, 0, 0});
  double fastest = 0;
  for (int i = 0; i < 480; ++i) {
    bodies->step();
    fastest = std::max(fastest, std::abs(bodies->velocity(shoulder)));
  }
  EXPECT_NEAR(bodies->position(shoulder), start[shoulder] + 1, 0.002);
  EXPECT_LT(fastest, mobile_baxter().joints()[shoulder].max_velocity * 1.05);
}

TEST(DynamicRobot, FingersStayCoupled) {
  const auto start = untucked();
  const auto bodies = make_bodies(WorldSpec{}, mobile_baxter(), start, true);
  hold(*bodies, start);
  for (const double target : {0.0, 0.0208, 0.01}) {
    bodies->set_target(kFinger, {Drive::kPosition, target, 0, 0, 0});
    for (int i = 0; i < 120; ++i) {
      bodies->step();
      ASSERT_NEAR(bodies->position(kFinger), -bodies->position(kOtherFinger), 1e-4) << "step " << i;
    }
    EXPECT_NEAR(bodies->position(kFinger), target, 1e-4);
  }
}

TEST(DynamicRobot, PressingOnATableStaysBounded) {
  WorldSpec world;
  world.bodies = {body("table", Mobility::kFixed, box_of(0.6, 1.2, 0.03), make_pose({0.9, 0.3, 0.685}))};
  const auto above = reach("left", from_above({0.75, 0.3, 0.75}), untucked());
  const auto below = reach("left", from_above({0.75, 0.3, 0.55}), above);
  const auto bodies = make_bodies(world, mobile_baxter(), above, true);
  JointDriver driver(*bodies, above);
  const int hand = link_index("left_gripper");
  driver.move(below, 1, [&] {
    ASSERT_GT(bodies->world_T_link(hand).translation().z(), 0.65);
    for (const int joint : arm_joints("left")) ASSERT_LT(std::abs(bodies->velocity(joint)), 5);
  });
  for (int i = 0; i < 480; ++i) {
    bodies->step();
    for (const int joint : arm_joints("left"))
      ASSERT_LT(std::abs(bodies->velocity(joint)), 2) << "step " << i;
  }
  driver.move(above, 1);
  driver.move(above, 0.5);
  EXPECT_LT((bodies->world_T_link(hand).translation() - Eigen::Vector3d(0.75, 0.3, 0.75)).norm(), 0.003);
}

TEST(DynamicRobot, StartsThatTouchDoNotExplode) {
  WorldSpec world;
  world.bodies = {body("table", Mobility::kFixed, box_of(0.6, 1.2, 0.03), make_pose({0.9, 0.3, 0.685})),
                  make_cube("cube", 0.05, {0.75, 0.3, 0.725})};
  // The tips are 2 cm deep in the table, with the cube between them.
  const auto start = reach("left", from_above({0.75, 0.3, 0.68}), untucked());
  const auto bodies = make_bodies(world, mobile_baxter(), start, true);
  hold(*bodies, start);
  for (int i = 0; i < 480; ++i) {
    bodies->step();
    for (const int joint : arm_joints("left"))
      ASSERT_LT(std::abs(bodies->velocity(joint)), 5) << "step " << i;
    ASSERT_LT(bodies->body_velocity(1).norm(), 3) << "step " << i;
  }
}

}  // namespace
}  // namespace extperfc::simulate
