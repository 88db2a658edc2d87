#include <limits>

#include "test/unit/simulate/bodies/baxter_arm.hpp"

namespace extperfc::simulate {
namespace {

constexpr double kTop = 0.70;  // of the table [m]
const Eigen::Vector3d kCube(0.75, 0.30, kTop + 0.025);

WorldSpec table_with_cube(const Eigen::Vector3d& cube = kCube) {
  WorldSpec world;
  world.bodies = {
      make_floor(),
      body("table", Mobility::kFixed, box_of(0.6, 1.2, 0.03), make_pose({0.9, 0.3, kTop - 0.015})),
      make_cube("cube", 0.05, cube)};
  return world;
}

const int kFinger = joint_index("l_gripper_l_finger_joint");

std::vector<double> at_cube() {
  return reach("left", from_above(kCube - Eigen::Vector3d(0, 0, 0.008)), untucked());
}

TEST(KinematicRobot, JointsFollowTheirSetPoints) {
  const auto start = untucked();
  const auto bodies = make_bodies(WorldSpec{}, mobile_baxter(), start);
  const int elbow = joint_index("left_e1");
  bodies->set_target(elbow, {Drive::kPosition, 1.5, 0, 0, 0});
  bodies->step();
  EXPECT_DOUBLE_EQ(bodies->position(elbow), 1.5);
  EXPECT_NEAR(bodies->velocity(elbow), (1.5 - start[elbow]) / kStep, 1e-9);
  bodies->step();
  EXPECT_DOUBLE_EQ(bodies->velocity(elbow), 0);
  auto expected = start;
  expected[elbow] = 1.5;
  const auto poses = mobile_baxter().link_poses(expected);
  for (int i = 0; i < static_cast<int>(poses.size()); ++i)
    EXPECT_TRUE(bodies->world_T_link(i).isApprox(poses[i], 1e-9)) << mobile_baxter().links()[i].name;
}

TEST(KinematicRobot, TargetsOutsideTheLimitsOrNotFiniteDoNoHarm) {
  const auto bodies = make_bodies(WorldSpec{}, mobile_baxter(), untucked());
  const int elbow = joint_index("left_e1");
  bodies->set_target(elbow, {Drive::kPosition, 7, 0, 0, 0});
  bodies->step();
  EXPECT_DOUBLE_EQ(bodies->position(elbow), mobile_baxter().joints()[elbow].upper);
  bodies->set_target(elbow, {Drive::kPosition, std::numeric_limits<double>::quiet_NaN(), 0, 0, 0});
  bodies->step();
  EXPECT_DOUBLE_EQ(bodies->position(elbow), mobile_baxter().joints()[elbow].upper);
}

TEST(KinematicRobot, WheelsTurnAndMimicFingersFollow) {
  const auto bodies = make_bodies(WorldSpec{}, mobile_baxter(), untucked());
  const int wheel = joint_index("wheel_front_left_joint");
  bodies->set_target(wheel, {Drive::kPosition, 50, 0, 0, 0});
  bodies->set_target(kFinger, {Drive::kPosition, 0.004, 0, 0, 0});
  step(*bodies, 0.3);
  EXPECT_DOUBLE_EQ(bodies->position(wheel), 50);
  EXPECT_DOUBLE_EQ(bodies->position(kFinger), 0.004);
  EXPECT_DOUBLE_EQ(bodies->position(joint_index("l_gripper_r_finger_joint")), -0.004);
}

TEST(KinematicRobot, EffortIsWhatHoldsTheArm) {
  const auto bodies = make_bodies(WorldSpec{}, mobile_baxter(), untucked());
  const int shoulder = joint_index("left_s1");
  bodies->step();
  EXPECT_DOUBLE_EQ(bodies->effort(shoulder), bodies->gravity_efforts()[shoulder]);
  EXPECT_LT(bodies->effort(shoulder), -5) << "an arm in front of the shoulder hangs on it";
}

TEST(KinematicRobot, HandPushesACubeAndTheTableStopsNothing) {
  const auto bodies = make_bodies(table_with_cube(), mobile_baxter(), [] {
    auto start = reach("left", from_above(kCube + Eigen::Vector3d(0, -0.15, -0.01)), untucked());
    start[kFinger] = 0;
    return start;
  }());
  auto goal = reach("left", from_above(kCube + Eigen::Vector3d(0, 0.05, -0.01)), untucked());
  goal[kFinger] = 0;
  auto start = reach("left", from_above(kCube + Eigen::Vector3d(0, -0.15, -0.01)), untucked());
  start[kFinger] = 0;
  JointDriver driver(*bodies, start);
  driver.move(goal, 2);
  driver.move(goal, 1);
  const Eigen::Vector3d cube = bodies->world_T_body(2).translation();
  EXPECT_GT(cube.y(), kCube.y() + 0.07) << "not pushed";
  EXPECT_LT(cube.y(), kCube.y() + 0.14) << "knocked away";
  EXPECT_NEAR(cube.z(), kCube.z(), 0.002);
}

TEST(KinematicRobot, FingersStopAtACubeAndLetItGo) {
  const auto at = at_cube();
  const auto bodies = make_bodies(table_with_cube(), mobile_baxter(), at);
  bodies->set_target(kFinger, {Drive::kPosition, 0, 0, 0, 8});
  step(*bodies, 0.5);
  // The gap is 16 mm + 2 q.
  EXPECT_NEAR(bodies->position(kFinger), 0.017, 0.0003);
  EXPECT_EQ(bodies->gripped(kFinger), 2);
  EXPECT_DOUBLE_EQ(bodies->grip_force(kFinger), 8);
  EXPECT_EQ(bodies->gripped(joint_index("r_gripper_l_finger_joint")), std::nullopt);
  bodies->set_target(kFinger, {Drive::kPosition, 0.0208, 0, 0, 8});
  step(*bodies, 0.5);
  EXPECT_NEAR(bodies->position(kFinger), 0.0208, 1e-9);
  EXPECT_EQ(bodies->gripped(kFinger), std::nullopt);
  EXPECT_DOUBLE_EQ(bodies->grip_force(kFinger), 0);
  EXPECT_LT((bodies->world_T_body(2).translation() - kCube).norm(), 0.001);
}

TEST(KinematicRobot, FingersCentreACubeThatStandsAside) {
  const auto bodies =
      make_bodies(table_with_cube(kCube + Eigen::Vector3d(0, 0.003, 0)), mobile_baxter(), at_cube());
  bodies->set_target(kFinger, {Drive::kPosition, 0, 0, 0, 0});
  step(*bodies, 0.5);
  EXPECT_EQ(bodies->gripped(kFinger), 2);
  EXPECT_NEAR(bodies->world_T_body(2).translation().y(), kCube.y(), 0.0015);
}

TEST(KinematicRobot, EmptyFingersCloseAndGripNothing) {
  const auto bodies = make_bodies(WorldSpec{}, mobile_baxter(), untucked());
  bodies->set_target(kFinger, {Drive::kPosition, 0, 0, 0, 0});
  step(*bodies, 0.3);
  EXPECT_DOUBLE_EQ(bodies->position(kFinger), 0);
  EXPECT_EQ(bodies->gripped(kFinger), std::nullopt);
}

TEST(KinematicRobot, HeldCubeStaysOnTheTableThatIsInTheWay) {
  const auto at = at_cube();
  const auto bodies = make_bodies(table_with_cube(), mobile_baxter(), at);
  auto closed = at;
  closed[kFinger] = 0;
  JointDriver driver(*bodies, at);
  driver.move(closed, 0.3);
  ASSERT_EQ(bodies->gripped(kFinger), 2);
  auto below = reach("left", from_above(kCube - Eigen::Vector3d(0, 0, 0.028)), at);
  below[kFinger] = 0;
  driver.move(below, 1);
  EXPECT_NEAR(bodies->world_T_body(2).translation().z(), kCube.z(), 0.003);
  driver.move(closed, 1);
  EXPECT_LT(bodies->body_velocity(2).norm(), 0.5);
  EXPECT_EQ(bodies->gripped(kFinger), 2);
}

TEST(KinematicRobot, MovedBodyIsNoLongerHeld) {
  const auto at = at_cube();
  const auto bodies = make_bodies(table_with_cube(), mobile_baxter(), at);
  bodies->set_target(kFinger, {Drive::kPosition, 0, 0, 0, 0});
  step(*bodies, 0.4);
  ASSERT_EQ(bodies->gripped(kFinger), 2);
  const Eigen::Vector3d elsewhere(1.0, 0.6, kCube.z());
  ASSERT_TRUE(bodies->move_body(2, make_pose(elsewhere)));
  EXPECT_EQ(bodies->gripped(kFinger), std::nullopt);
  step(*bodies, 0.5);
  EXPECT_LT((bodies->world_T_body(2).translation() - elsewhere).norm(), 0.001);
}

}  // namespace
}  // namespace extperfc::simulate
