#pragma once

#include <string>

#include "extperfc/simulate/robot_io.hpp"

/// Names of a Baxter's parts, relative to the robot's namespace.
namespace extperfc::ros_robot {

inline constexpr const char* kBaseFrame = "base";  ///< of poses of the end points

/// "left_s0"
[[nodiscard]] inline std::string joint_name(simulate::Side side, int index) {
  return std::string(to_string(side)) + "_" + simulate::kArmJointNames[index];
}
/// "robot/limb/left/<leaf>"
[[nodiscard]] inline std::string limb_name(simulate::Side side, const std::string& leaf) {
  return std::string("robot/limb/") + to_string(side) + "/" + leaf;
}
/// "robot/end_effector/left_gripper/<leaf>"
[[nodiscard]] inline std::string gripper_name(simulate::Side side, const std::string& leaf) {
  return std::string("robot/end_effector/") + to_string(side) + "_gripper/" + leaf;
}

}  // namespace extperfc::ros_robot
