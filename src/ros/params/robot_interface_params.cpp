#include "ros/params/robot_interface_params.hpp"

#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

Result<RobotInterfaceParams> load_robot_interface_params(const ros::NodeHandle& private_handle) {
  RobotInterfaceParams params;
  auto& trajectory = params.trajectory;
  ParamReader reader(ros::NodeHandle(private_handle, "robot"));
  reader.read("joint_state_rate_hz", params.joint_state_rate_hz, {1.0, 1000.0});
  reader.read("state_rate_hz", params.state_rate_hz, {1.0, 1000.0});
  reader.read("feedback_rate_hz", params.feedback_rate_hz, {1.0, 1000.0});
  reader.read("path_tolerance_rad", trajectory.path_tolerance_rad, {0.001, 10.0});
  reader.read("goal_tolerance_rad", trajectory.goal_tolerance_rad, {0.0001, 10.0});
  reader.read("goal_time_s", trajectory.goal_time_s, {0.0, 120.0});
  reader.read("stopped_velocity_rad_s", trajectory.stopped_velocity_rad_s, {0.001, 10.0});
  reader.read("stop_deceleration_rad_s2", trajectory.stop_deceleration_rad_s2, {0.1, 50.0});
  reader.read("longest_wait_for_start_s", trajectory.longest_wait_for_start_s, {0.0, 1e6});
  reader.read("gripper_tolerance_percent", params.gripper_tolerance_percent, {0.1, 50.0});
  reader.read("gripper_timeout_s", params.gripper_timeout_s, {0.1, 600.0});
  reader.read("tuck_speed_rad_s", params.tuck_speed_rad_s, {0.01, 1.5});
  reader.read("tuck_accel_rad_s2", params.tuck_accel_rad_s2, {0.01, 10.0});
  if (auto finished = reader.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

}  // namespace extperfc::ros_params
