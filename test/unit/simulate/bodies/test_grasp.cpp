#include "test/unit/simulate/bodies/baxter_arm.hpp"

namespace extperfc::simulate {
namespace {

constexpr double kTop = 0.70;  // of the table [m]
const Eigen::Vector3d kCube(0.75, 0.30, kTop + 0.025);

WorldSpec table_with_cube() {
  WorldSpec world;
  world.bodies = {
      make_floor(),
      body("table", Mobility::kFixed, box_of(0.6, 1.2, 0.03), make_pose({0.9, 0.3, kTop - 0.015})),
      make_cube("cube", 0.05, kCube)};
  return world;
}

/// Postures of the motion: above the cube, at it, and lifted, with the gripper open.
struct Plan {
  std::vector<double> above, at, lifted;
};

Plan make_plan() {
  Plan plan;
  plan.at = reach("left", from_above(kCube - Eigen::Vector3d(0, 0, 0.008)), untucked());
  plan.above = reach("left", from_above(kCube + Eigen::Vector3d(0, 0, 0.10)), plan.at);
  plan.lifted = reach("left", from_above(kCube + Eigen::Vector3d(0, 0, 0.192)), plan.above);
  return plan;
}

std::vector<double> closed(std::vector<double> positions) {
  positions[joint_index("l_gripper_l_finger_joint")] = 0.0;
  return positions;
}

struct Mode {
  const char* name;
  bool dynamic;
  bool hold_gripped;
  double max_slip_m;
};

class Grasp : public ::testing::TestWithParam<Mode> {};

TEST_P(Grasp, CubeIsLiftedCarriedAndPutDown) {
  const Plan plan = make_plan();
  BodiesParams params;
  params.dynamic = GetParam().dynamic;
  params.hold_gripped = GetParam().hold_gripped;
  auto made = Bodies::make(params, mobile_baxter(), table_with_cube(), Pose::Identity(), plan.above);
  ASSERT_TRUE(made) << made.error().message;
  Bodies& bodies = **made;
  const int finger = joint_index("l_gripper_l_finger_joint");
  const int hand = link_index("left_gripper");
  JointDriver driver(bodies, plan.above);
  driver.move(plan.above, 2.5);  // the cube falls asleep
  driver.move(plan.at, 1.5);
  EXPECT_FALSE(bodies.gripped(finger));
  driver.move(closed(plan.at), 0.4);
  driver.move(closed(plan.at), 0.4);
  ASSERT_EQ(bodies.gripped(finger), 2);
  EXPECT_GT(bodies.grip_force(finger), 10);
  const Pose hand_T_cube = bodies.world_T_link(hand).inverse() * bodies.world_T_body(2);
  double slip = 0;
  double rotation = 0;
  const auto watch = [&] {
    const Pose now = bodies.world_T_link(hand).inverse() * bodies.world_T_body(2);
    slip = std::max(slip, (now.translation() - hand_T_cube.translation()).norm());
    rotation = std::max(rotation, Eigen::AngleAxisd(hand_T_cube.linear().transpose() * now.linear()).angle());
  };
  driver.move(closed(plan.lifted), 1.5, watch);
  EXPECT_NEAR(bodies.world_T_body(2).translation().z(), kCube.z() + 0.2, 0.006);
  // Ten seconds of carrying with the shoulder and the wrist.
  auto swung = closed(plan.lifted);
  swung[joint_index("left_s0")] += 0.5;
  swung[joint_index("left_w1")] += 0.4;
  swung[joint_index("left_w2")] -= 1.0;
  driver.move(swung, 4, watch);
  driver.move(swung, 2, watch);
  driver.move(closed(plan.lifted), 4, watch);
  RecordProperty("slip_mm", std::to_string(1e3 * slip));
  RecordProperty("rotation_rad", std::to_string(rotation));
  EXPECT_EQ(bodies.gripped(finger), 2);
  driver.move(closed(plan.at), 1.5, watch);
  EXPECT_LT(slip, GetParam().max_slip_m);
  EXPECT_LT(rotation, 0.2);
  driver.move(plan.at, 0.4);
  EXPECT_FALSE(bodies.gripped(finger));
  driver.move(plan.above, 1);
  driver.move(plan.above, 1);
  EXPECT_LT((bodies.world_T_body(2).translation() - kCube).norm(), 0.008);
  EXPECT_LT(bodies.body_velocity(2).norm(), 1e-3);
}

TEST(GraspOblique, WhatIsHeldAsWideAsTheGripperOpensIsLetGo) {
  // The pads, 58 mm apart at most, hold the cube across its edges.
  constexpr double kYaw = 0.42;
  WorldSpec world = table_with_cube();
  const Eigen::Vector3d place(kCube.x(), kCube.y(), kTop + 0.0225);
  world.bodies[2] = make_cube("cube", 0.045, place);
  world.bodies[2].world_T_body = make_pose(place, {0, 0, kYaw});
  const Plan plan = make_plan();
  auto made = Bodies::make({}, mobile_baxter(), world, Pose::Identity(), plan.above);
  ASSERT_TRUE(made) << made.error().message;
  Bodies& bodies = **made;
  const int finger = joint_index("l_gripper_l_finger_joint");
  JointDriver driver(bodies, plan.above);
  driver.move(plan.above, 1);
  driver.move(plan.at, 1.5);
  driver.move(closed(plan.at), 0.8);
  ASSERT_EQ(bodies.gripped(finger), 2);
  ASSERT_GT(bodies.position(finger), 0.0203) << "it opens to 0.0208";
  driver.move(closed(plan.above), 1.5);
  EXPECT_GT(bodies.world_T_body(2).translation().z(), place.z() + 0.09);
  driver.move(closed(plan.at), 1.5);
  driver.move(plan.at, 0.4);
  driver.move(plan.above, 1.5);
  EXPECT_FALSE(bodies.gripped(finger));
  EXPECT_NEAR(bodies.world_T_body(2).translation().z(), place.z(), 0.002);
}

INSTANTIATE_TEST_SUITE_P(Modes, Grasp,
                         ::testing::Values(Mode{"kinematic", false, true, 1e-5},
                                           Mode{"dynamic_held", true, true, 0.001},
                                           Mode{"dynamic_by_friction", true, false, 0.005}),
                         [](const auto& mode) { return mode.param.name; });

}  // namespace
}  // namespace extperfc::simulate
