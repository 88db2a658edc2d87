#pragma once

#include <stdexcept>
#include <string>

#include "extperfc/arm/motion_pipeline.hpp"
#include "extperfc/arm/robot_arms.hpp"

namespace extperfc::arm::test {

inline const RobotArms& baxter_arms() {
  static const RobotArms arms =
      RobotArms::make(
          RobotModel::from_file(EXTPERFC_SOURCE_DIR "/urdf/mobile_baxter.urdf", EXTPERFC_SOURCE_DIR).value(),
          read_srdf(EXTPERFC_SOURCE_DIR "/config/robots/baxter/mobile_baxter.srdf").value())
          .value();
  return arms;
}

/// Both arms in a state of the SRDF, fingers open, head ahead.
inline JointPositions standing(const std::string& state) {
  return baxter_arms().named_state(**baxter_arms().group("both_arms"), state).value();
}

/// A table of 0.7 m x 1.5 m before the robot, its top at `top_m` above the floor.
inline CollisionWorld table_world(double top_m) {
  CollisionWorld world;
  Shape top;
  top.geometry = Box{{0.7, 1.5, 0.04}};
  const Pose floor_T_table = make_pose({0.95, 0.0, top_m - 0.02});
  if (auto added = world.add({"table", {top}, floor_T_table}); !added)
    throw std::runtime_error(added.error().message);
  return world;
}

}  // namespace extperfc::arm::test
