#pragma once

#include <cmath>
#include <filesystem>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/simulate/simulator.hpp"

namespace extperfc::simulate {

/// The robot in an empty room with one cube on the floor, far ahead.
inline WorldSpec cube_world() {
  WorldSpec world;
  world.name = "cube";
  BodySpec floor;
  floor.name = "floor";
  floor.world_T_body = make_pose({0, 0, -0.05});
  floor.shapes = {{Box{{20, 20, 0.1}}, Pose::Identity(), {}}};
  BodySpec cube;
  cube.name = "cube";
  cube.label = "cube";
  cube.mobility = Mobility::kLoose;
  cube.mass_kg = 0.1;
  cube.world_T_body = make_pose({2, 0, 0.3});
  cube.shapes = {{Box{{0.05, 0.05, 0.05}}, Pose::Identity(), {}}};
  BodySpec wall;
  wall.name = "wall";
  wall.mobility = Mobility::kMovable;
  wall.world_T_body = make_pose({0, 5, 1});
  wall.shapes = {{Box{{4, 0.1, 2}}, Pose::Identity(), {}}};
  world.bodies = {floor, cube, wall};
  return world;
}

class SimulatorTest : public testing::Test {
 protected:
  static std::unique_ptr<Simulator> make(SimulatorParams params = {}) {
    params.start_enabled = true;
    const std::filesystem::path root = EXTPERFC_SOURCE_DIR;
    auto robot = RobotModel::from_file(root / "urdf/mobile_baxter.urdf", root);
    if (!robot) {
      ADD_FAILURE() << robot.error().message;
      return nullptr;
    }
    auto simulator = Simulator::make(params, *robot, cube_world());
    if (!simulator) {
      ADD_FAILURE() << simulator.error().message;
      return nullptr;
    }
    return std::move(*simulator);
  }

  void SetUp() override {
    simulator_ = make();
    ASSERT_NE(simulator_, nullptr);
  }

  void run(double seconds) {
    for (int i = 0; i < std::lround(seconds / simulator_->params().bodies.step_s); ++i) simulator_->step();
  }
  /// Commands a joint of the left arm over and over, as a driver does.
  void hold_command(ArmMode mode, int joint, double value, double seconds) {
    ArmCommand command{mode, {}};
    command.values[joint] = value;
    for (int i = 0; i < std::lround(seconds * 20); ++i) {
      ASSERT_TRUE(simulator_->command_arm(Side::kLeft, command));
      run(0.05);
    }
  }
  [[nodiscard]] ArmState left() const { return simulator_->arm_state(Side::kLeft); }
  [[nodiscard]] double joint(const std::string& name) const {
    const auto sample = simulator_->joints();
    for (std::size_t i = 0; i < sample.names.size(); ++i)
      if (sample.names[i] == name) return sample.position[i];
    ADD_FAILURE() << "no joint " << name;
    return NAN;
  }

  std::unique_ptr<Simulator> simulator_;
};

}  // namespace extperfc::simulate
