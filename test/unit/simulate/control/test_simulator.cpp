#include "test/unit/simulate/control/simulator_test.hpp"

namespace extperfc::simulate {
namespace {

TEST_F(SimulatorTest, StartsUntuckedWithTheEndPointWhereBaxterHasIt) {
  // base to left_gripper in the pose `untuck` of the real robot's description.
  EXPECT_NEAR((left().base_T_endpoint.translation() - Eigen::Vector3d(0.579711, 0.183294, 0.1137)).norm(), 0,
              1e-4);
  EXPECT_NEAR(left().position[3], 1.94, 1e-9);
  EXPECT_NEAR(simulator_->arm_state(Side::kRight).position[2], 1.19, 1e-9);
}

TEST_F(SimulatorTest, TimeIsCountedInSteps) {
  run(1.0);
  EXPECT_DOUBLE_EQ(simulator_->time_s(), 240 * simulator_->params().bodies.step_s);
}

TEST_F(SimulatorTest, ArmGoesWhereItIsCommanded) {
  hold_command(ArmMode::kPosition, 1, -0.6, 3.0);
  EXPECT_NEAR(left().position[1], -0.6, 1e-6);
  EXPECT_NEAR(left().velocity[1], 0, 1e-6);
}

TEST_F(SimulatorTest, TwistIsTheEndPointsVelocity) {
  ArmCommand command{ArmMode::kVelocity, {}};
  command.values[0] = 0.5;
  ASSERT_TRUE(simulator_->command_arm(Side::kLeft, command));
  run(0.15);  // up to speed, before the time-out
  const Eigen::Vector3d before = left().base_T_endpoint.translation();
  simulator_->step();
  const Eigen::Vector3d moved = left().base_T_endpoint.translation() - before;
  EXPECT_NEAR((moved / simulator_->params().bodies.step_s - left().twist.head<3>()).norm(), 0, 2e-3);
  EXPECT_NEAR(left().twist[5], 0.5, 1e-3) << "s0 turns about z";
}

TEST_F(SimulatorTest, DisabledRobotDoesNotMoveAndEmergencyStopHolds) {
  simulator_->enable(false);
  const double start = left().position[1];
  hold_command(ArmMode::kPosition, 1, -0.6, 0.5);
  EXPECT_EQ(left().position[1], start);
  simulator_->enable(true);
  hold_command(ArmMode::kPosition, 1, -0.6, 0.3);
  simulator_->stop();
  const double stopped = left().position[1];
  EXPECT_NE(stopped, start);
  simulator_->enable(true);
  EXPECT_FALSE(simulator_->robot_state().enabled) << "not while it is stopped";
  hold_command(ArmMode::kPosition, 1, -0.6, 0.5);
  EXPECT_EQ(left().position[1], stopped);
  simulator_->reset_stop();
  simulator_->enable(true);
  hold_command(ArmMode::kPosition, 1, -0.6, 3.0);
  EXPECT_NEAR(left().position[1], -0.6, 1e-6);
}

TEST_F(SimulatorTest, TorqueNeedsDynamicArms) {
  const auto refused = simulator_->command_arm(Side::kLeft, {ArmMode::kTorque, {}});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("dynamic"), std::string::npos);
}

TEST_F(SimulatorTest, RefusesCommandsThatAreNoNumbers) {
  ArmCommand command{ArmMode::kPosition, {}};
  command.values[2] = std::nan("");
  EXPECT_FALSE(simulator_->command_arm(Side::kRight, command));
}

TEST_F(SimulatorTest, GripperCalibratesClosesAndMissesNothing) {
  ASSERT_TRUE(
      simulator_->command_gripper(Side::kLeft, {GripperCommand::Kind::kCalibrate, 0, {}, {}, {}, {}}));
  run(3.0);
  ASSERT_TRUE(simulator_->gripper_state(Side::kLeft).calibrated);
  ASSERT_TRUE(simulator_->command_gripper(Side::kLeft, {GripperCommand::Kind::kGoTo, 50, {}, {}, {}, {}}));
  run(1.0);
  EXPECT_NEAR(simulator_->gripper_state(Side::kLeft).position_percent, 50, 1);
  EXPECT_NEAR(joint("l_gripper_r_finger_joint"), -joint("l_gripper_l_finger_joint"), 1e-4);
}

TEST_F(SimulatorTest, HeadPansWithinItsLimits) {
  simulator_->command_head_pan(9.0, 1.0);
  run(3.0);
  EXPECT_NEAR(simulator_->head_state().pan, 1.3963, 1e-6);
  EXPECT_NEAR(joint("head_pan"), 1.3963, 1e-6);
  EXPECT_FALSE(simulator_->head_state().turning);
}

TEST_F(SimulatorTest, BaseCarriesEverything) {
  for (int i = 0; i < 40; ++i) {
    simulator_->command_base({0.5, 0, 0});
    run(0.05);
  }
  const auto snapshot = simulator_->snapshot();
  const auto endpoint = *simulator_->robot().link("left_gripper");
  const auto base = *simulator_->robot().link("base");
  EXPECT_GT(simulator_->base_state().truth.x, 0.7);
  const Pose base_T_endpoint = snapshot.world_T_link[base].inverse() * snapshot.world_T_link[endpoint];
  EXPECT_NEAR((base_T_endpoint.translation() - left().base_T_endpoint.translation()).norm(), 0, 1e-6);
  EXPECT_NEAR(snapshot.world_T_link[0].translation().x(), simulator_->base_state().truth.x, 1e-9);
}

TEST_F(SimulatorTest, AWallStopsTheBase) {
  ASSERT_TRUE(simulator_->move_body("wall", make_pose({1.0, 0, 1}, {0, 0, M_PI / 2})));
  for (int i = 0; i < 80; ++i) {
    simulator_->command_base({0.5, 0, 0});
    run(0.05);
  }
  EXPECT_TRUE(simulator_->base_state().blocked);
  EXPECT_LT(simulator_->base_state().truth.x, 0.95 - 0.39) << "the footprint is 0.8 m long";
  EXPECT_GT(simulator_->base_state().odometry.x, 1.0);
}

TEST_F(SimulatorTest, LooseObjectsFallAndCanBeMoved) {
  run(1.5);
  EXPECT_NEAR(simulator_->snapshot().world_T_body[1].translation().z(), 0.025, 2e-3);
  ASSERT_TRUE(simulator_->move_body("cube", make_pose({1, 1, 0.5})));
  EXPECT_NEAR(simulator_->snapshot().world_T_body[1].translation().x(), 1, 1e-9);
  EXPECT_FALSE(simulator_->move_body("floor", make_pose({0, 0, 1})));
  const auto missing = simulator_->move_body("sofa", make_pose({0, 0, 1}));
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("sofa"), std::string::npos);
}

TEST_F(SimulatorTest, ResetIsTheStart) {
  const auto drive = [this] {
    simulator_->command_base({0.3, 0.1, 0.2});
    hold_command(ArmMode::kPosition, 1, -0.6, 1.0);
    return simulator_->snapshot();
  };
  const auto first = drive();
  ASSERT_TRUE(simulator_->reset());
  EXPECT_EQ(simulator_->time_s(), 0);
  const auto second = drive();
  for (std::size_t i = 0; i < first.world_T_link.size(); ++i)
    EXPECT_EQ(first.world_T_link[i].matrix(), second.world_T_link[i].matrix()) << "link " << i;
  for (std::size_t i = 0; i < first.world_T_body.size(); ++i)
    EXPECT_EQ(first.world_T_body[i].matrix(), second.world_T_body[i].matrix()) << "body " << i;
}

/// Same seed and commands, same states; kinematic and dynamic.
class Determinism : public SimulatorTest, public testing::WithParamInterface<bool> {};

TEST_P(Determinism, TwoRunsAreEqualBitForBit) {
  SimulatorParams params;
  params.bodies.dynamic = GetParam();
  std::vector<Snapshot> ends;
  for (int run_number = 0; run_number < 2; ++run_number) {
    simulator_ = make(params);
    ASSERT_NE(simulator_, nullptr);
    simulator_->command_base({0.3, -0.2, 0.4});
    hold_command(ArmMode::kPosition, 3, 1.2, 1.0);
    hold_command(ArmMode::kVelocity, 0, -0.3, 0.5);
    ends.push_back(simulator_->snapshot());
  }
  for (std::size_t i = 0; i < ends[0].world_T_link.size(); ++i)
    EXPECT_EQ(ends[0].world_T_link[i].matrix(), ends[1].world_T_link[i].matrix()) << "link " << i;
  for (std::size_t i = 0; i < ends[0].world_T_body.size(); ++i)
    EXPECT_EQ(ends[0].world_T_body[i].matrix(), ends[1].world_T_body[i].matrix()) << "body " << i;
}

INSTANTIATE_TEST_SUITE_P(Modes, Determinism, testing::Bool(),
                         [](const auto& mode) { return mode.param ? "Dynamic" : "Kinematic"; });

class DynamicSimulator : public SimulatorTest {
 protected:
  void SetUp() override {
    SimulatorParams params;
    params.bodies.dynamic = true;
    simulator_ = make(params);
    ASSERT_NE(simulator_, nullptr);
  }
};

TEST_F(DynamicSimulator, ArmGoesWhereItIsCommandedAndHolds) {
  hold_command(ArmMode::kPosition, 1, -0.6, 3.0);
  EXPECT_NEAR(left().position[1], -0.6, 0.01);
  run(1.0);
  EXPECT_NEAR(left().position[1], -0.6, 0.01);
  EXPECT_GT(std::abs(left().effort[1]), 1.0) << "it holds the arm's weight";
}

TEST_F(DynamicSimulator, ZeroTorqueFloatsAndTorqueMoves) {
  ArmCommand command{ArmMode::kTorque, {}};
  for (auto& value : command.values) value = 0.0;
  const double start = left().position[1];
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(simulator_->command_arm(Side::kLeft, command));
    run(0.05);
  }
  EXPECT_NEAR(left().position[1], start, 0.1) << "gravity is compensated";
  command.values[5] = 1.0;
  const double before = left().position[5];
  for (int i = 0; i < 6; ++i) {
    ASSERT_TRUE(simulator_->command_arm(Side::kLeft, command));
    run(0.05);
  }
  EXPECT_GT(left().position[5], before + 0.05);
}

TEST(SimulatorParamsCheck, NamesEveryValueOutOfItsRange) {
  const std::filesystem::path root = EXTPERFC_SOURCE_DIR;
  auto robot = RobotModel::from_file(root / "urdf/mobile_baxter.urdf", root);
  ASSERT_TRUE(robot);
  SimulatorParams params;
  params.base.max_speed_m_s = -1;
  params.arms.command_timeout_s = 7;
  const auto refused = Simulator::make(params, *robot, cube_world());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("max_speed_m_s"), std::string::npos);
  EXPECT_NE(refused.error().message.find("command_timeout_s"), std::string::npos);
  params = {};
  params.arms.start_pose = "handstand";
  const auto unknown = Simulator::make(params, *robot, cube_world());
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("handstand"), std::string::npos);
}

}  // namespace
}  // namespace extperfc::simulate
