#pragma once

#include <array>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/robot_io.hpp"
#include "extperfc/world/robot_model.hpp"

#include "simulate/control/set_point.hpp"

namespace extperfc::simulate {

/// Where the parts of a mobile Baxter stand in a RobotModel: indices of its joints and links.
struct RobotJoints {
  struct Arm {
    std::array<int, kArmJoints> joints{};
    int finger{-1};    ///< joint that drives the gripper; the other finger mimics it
    int endpoint{-1};  ///< link <side>_gripper
  };
  std::array<Arm, 2> arms;
  int head_pan{-1};
  std::array<int, 4> wheels{};  ///< front left, front right, rear left, rear right
  int base{-1};                 ///< link `base`, Baxter's own reference
};

/// Error: names the first joint or link that the description lacks.
[[nodiscard]] Result<RobotJoints> find_joints(const RobotModel& robot);

/// Limits of a joint, with the acceleration that the description does not know.
[[nodiscard]] MotionLimits motion_limits(const Joint& joint, double max_accel);

/// Joint positions of the start: arms in a named pose (untuck, tuck, neutral), grippers open. Error: unknown
/// pose.
[[nodiscard]] Result<std::vector<double>> start_positions(const RobotModel& robot, const RobotJoints& joints,
                                                          const std::string& arm_pose);

/// Geometric Jacobian of an arm's end point, in the frame `base`: rows v then w, a column per arm joint.
using ArmJacobian = Eigen::Matrix<double, 6, kArmJoints>;
[[nodiscard]] ArmJacobian arm_jacobian(const RobotModel& robot, const RobotJoints& joints, Side side,
                                       const std::vector<Pose>& root_T_link);

}  // namespace extperfc::simulate
