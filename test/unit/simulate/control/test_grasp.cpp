// A cube is taken from a table, lifted, carried and put down, by the commands that a program on the robot
// has.
#include "test/unit/simulate/control/arm_driver.hpp"
#include "test/unit/simulate/control/simulator_test.hpp"

namespace extperfc::simulate {
namespace {

constexpr double kTable = 0.62;  // height of its top [m]
constexpr double kEdge = 0.04;   // of the cube [m]
constexpr int kCube = 2;         // index among the bodies

WorldSpec table_world() {
  WorldSpec world = cube_world();
  BodySpec table = world.bodies[0];
  table.name = "table";
  table.world_T_body = make_pose({0.85, 0.2, kTable / 2});
  table.shapes = {{Box{{0.6, 1.0, kTable}}, Pose::Identity(), {}}};
  BodySpec cube = world.bodies[1];
  cube.world_T_body = make_pose({0.70, 0.25, kTable + kEdge / 2});
  cube.shapes = {{Box{{kEdge, kEdge, kEdge}}, Pose::Identity(), {}}};
  world.bodies = {world.bodies[0], table, cube};
  return world;
}

/// The end point over the table, fingers down and closing along y; `height` over the floor.
Pose over(double x, double y, double height) {
  constexpr double kBaseHeight = 0.1016 + 0.5293;  // of Baxter's base over the floor
  Pose pose = make_pose({x, y, height - kBaseHeight});
  pose.linear() = Eigen::Vector3d(-1, 1, -1).asDiagonal();
  return pose;
}

/// Kinematic and dynamic arms.
class GraspTest : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    SimulatorParams params;
    params.start_enabled = true;
    params.bodies.dynamic = GetParam();
    const std::filesystem::path root = EXTPERFC_SOURCE_DIR;
    auto robot = RobotModel::from_file(root / "urdf/mobile_baxter.urdf", root);
    ASSERT_TRUE(robot) << robot.error().message;
    auto simulator = Simulator::make(params, *robot, table_world());
    ASSERT_TRUE(simulator) << simulator.error().message;
    simulator_ = std::move(*simulator);
    driver_.emplace(*simulator_, Side::kLeft);
    ASSERT_TRUE(
        simulator_->command_gripper(Side::kLeft, {GripperCommand::Kind::kCalibrate, 0, {}, {}, {}, {}}));
    driver_->hold(3.0);
  }

  void grip(double percent) {
    ASSERT_TRUE(
        simulator_->command_gripper(Side::kLeft, {GripperCommand::Kind::kGoTo, percent, {}, {}, {}, {}}));
    driver_->hold(1.0);
  }
  [[nodiscard]] Pose cube() const { return simulator_->snapshot().world_T_body[kCube]; }
  /// The cube as the hand sees it.
  [[nodiscard]] Pose in_hand() const {
    const auto snapshot = simulator_->snapshot();
    return snapshot.world_T_link[*simulator_->robot().link("left_gripper")].inverse() *
           snapshot.world_T_body[kCube];
  }

  std::unique_ptr<Simulator> simulator_;
  std::optional<ArmDriver> driver_;
};

TEST_P(GraspTest, CubeIsLiftedCarriedAndPutDownWithoutSlipping) {
  ASSERT_TRUE(driver_->line_to(over(0.70, 0.25, 0.80)));
  ASSERT_TRUE(driver_->line_to(over(0.70, 0.25, kTable + kEdge / 2)));
  EXPECT_NEAR((cube().translation() - Eigen::Vector3d(0.70, 0.25, kTable + kEdge / 2)).norm(), 0, 2e-3)
      << "the open gripper has not touched it";
  grip(0);
  ASSERT_TRUE(simulator_->gripper_state(Side::kLeft).gripping);
  const Eigen::Vector3d gripped = in_hand().translation();

  double slip = 0;
  const auto watch = [&] { slip = std::max(slip, (in_hand().translation() - gripped).norm()); };
  ASSERT_TRUE(driver_->line_to(over(0.70, 0.25, kTable + kEdge / 2 + 0.20)));
  watch();
  EXPECT_NEAR(cube().translation().z(), kTable + kEdge / 2 + 0.20, 0.01);
  for (int pass = 0; pass < 5; ++pass) {  // carried to and fro, 2 s each
    ASSERT_TRUE(driver_->line_to(over(0.70, pass % 2 == 0 ? 0.35 : 0.15, kTable + kEdge / 2 + 0.20)));
    driver_->hold(1.0, watch);
    simulator_->command_base({0, 0, pass % 2 == 0 ? 0.2 : -0.2});
  }
  EXPECT_LT(slip, 0.005);
  EXPECT_TRUE(simulator_->gripper_state(Side::kLeft).gripping);

  ASSERT_TRUE(driver_->line_to(over(0.70, 0.35, kTable + kEdge / 2 + 0.003)));
  watch();
  EXPECT_LT(slip, 0.005);
  RecordProperty("slip_mm", std::to_string(slip * 1e3));
  grip(100);
  EXPECT_FALSE(simulator_->gripper_state(Side::kLeft).gripping);
  ASSERT_TRUE(driver_->line_to(over(0.70, 0.35, 0.85)));
  driver_->hold(1.0);
  EXPECT_NEAR(cube().translation().z(), kTable + kEdge / 2, 2e-3) << "it stands on the table";
  EXPECT_GT(cube().translation().y(), 0.30) << "where it was put";
}

TEST_P(GraspTest, ClosingOnNothingIsAMiss) {
  ASSERT_TRUE(driver_->line_to(over(0.70, 0.05, 0.80)));
  grip(0);
  driver_->hold(1.0);
  EXPECT_FALSE(simulator_->gripper_state(Side::kLeft).gripping);
  EXPECT_TRUE(simulator_->gripper_state(Side::kLeft).missed);
}

INSTANTIATE_TEST_SUITE_P(Modes, GraspTest, testing::Bool(),
                         [](const auto& mode) { return mode.param ? "Dynamic" : "Kinematic"; });

}  // namespace
}  // namespace extperfc::simulate
