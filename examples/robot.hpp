#pragma once

#include "extperfc/arm/robot_arms.hpp"

#include "examples/example.hpp"

namespace extperfc::examples {

/// The mobile Baxter of this package. Another robot: give its URDF and SRDF.
inline arm::RobotArms baxter() {
  const std::filesystem::path root = EXTPERFC_SOURCE_DIR;
  return value_of(
      arm::RobotArms::make(value_of(RobotModel::from_file(root / "urdf/mobile_baxter.urdf", root)),
                           value_of(arm::read_srdf(root / "config/robots/baxter/mobile_baxter.srdf"))));
}

/// A world with a table of 0.7 m x 1.5 m before the robot.
inline arm::CollisionWorld table() {
  arm::CollisionWorld world;
  Shape top;
  top.geometry = Box{{0.7, 1.5, 0.04}};
  check(world.add({"table", {top}, make_pose({0.95, 0.0, 0.73})}));
  return world;
}

}  // namespace extperfc::examples
