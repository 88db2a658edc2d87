#pragma once

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/trajectory_follower.hpp"

namespace extperfc::ros_params {

struct RobotInterfaceParams {
  double joint_state_rate_hz{100.0};  ///< of robot/joint_states at the start, [1, 1000]
  double state_rate_hz{100.0};        ///< of robot/state, endpoint_state and the other states, [1, 1000]
  double feedback_rate_hz{100.0};     ///< of the actions' feedback, [1, 1000]
  simulate::TrajectoryFollowerParams trajectory;
  double gripper_tolerance_percent{5.0};  ///< of the opening: gripper_action has reached its goal, [0.1, 50]
  double gripper_timeout_s{5.0};          ///< gripper_action gives up after this long, [0.1, 600]
  double tuck_speed_rad_s{0.75};          ///< of the fastest joint, (0, 1.5]
  double tuck_accel_rad_s2{2.0};          ///< of the fastest joint, (0, 10]
};

/// Reads the namespace `robot` below `private_handle`; every problem is reported at once.
[[nodiscard]] Result<RobotInterfaceParams> load_robot_interface_params(const ros::NodeHandle& private_handle);

}  // namespace extperfc::ros_params
