#pragma once

#include <string>

#include "extperfc/simulate/robot_io.hpp"

/// Names of a Baxter's parts, relative to the robot's namespace.
namespace extperfc::robot_names {

inline constexpr const char* kBaseFrame = "base";  ///< of poses of the end points

/// "left_s0"
[[nodiscard]] inline std::string joint(simulate::Side side, int index) {
  return std::string(to_string(side)) + "_" + simulate::kArmJointNames[index];
}
/// "robot/limb/left/<leaf>"
[[nodiscard]] inline std::string limb(simulate::Side side, const std::string& leaf) {
  return std::string("robot/limb/") + to_string(side) + "/" + leaf;
}
/// "robot/end_effector/left_gripper/<leaf>"
[[nodiscard]] inline std::string gripper(simulate::Side side, const std::string& leaf) {
  return std::string("robot/end_effector/") + to_string(side) + "_gripper/" + leaf;
}

}  // namespace extperfc::robot_names
