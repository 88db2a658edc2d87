#pragma once

#include <string>

#include "extperfc/arm/grasp.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::arm::test {

inline const RobotModel& baxter() {
  static const RobotModel robot =
      RobotModel::from_file(EXTPERFC_SOURCE_DIR "/urdf/mobile_baxter.urdf", EXTPERFC_SOURCE_DIR).value();
  return robot;
}

/// Paddles: 16 to 57.7 mm.
inline const ParallelHand& left_hand() {
  static const ParallelHand hand = hand_of(baxter(), "left_gripper", "l_gripper_l_finger_joint").value();
  return hand;
}

/// Half round tips: 6.5 to 48.2 mm.
inline const ParallelHand& right_hand() {
  static const ParallelHand hand = hand_of(baxter(), "right_gripper", "r_gripper_l_finger_joint").value();
  return hand;
}

/// An object that stands on a table 0.1 m above the root.
inline GraspObject on_table(const Geometry& geometry, double height_m, double yaw_rad = 0) {
  constexpr double kTable = 0.1;
  GraspObject object;
  object.geometry = geometry;
  object.root_T_object = make_pose({0.7, 0.3, kTable + height_m / 2}, {0, 0, yaw_rad});
  object.support_z_m = kTable;
  return object;
}

inline GraspObject cube_on_table(double edge_m, double yaw_rad = 0) {
  return on_table(Box{Eigen::Vector3d::Constant(edge_m)}, edge_m, yaw_rad);
}

}  // namespace extperfc::arm::test
