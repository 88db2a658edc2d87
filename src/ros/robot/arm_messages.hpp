#pragma once

#include <baxter_core_msgs/AssemblyState.h>
#include <baxter_core_msgs/EndpointState.h>
#include <baxter_core_msgs/JointCommand.h>
#include <baxter_core_msgs/SEAJointState.h>
#include <sensor_msgs/JointState.h>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/robot_io.hpp"

/// Baxter's messages of robot, joints and arms <-> the simulator's types.
namespace extperfc::ros_robot {

/// Errors: unknown mode, a joint that this arm does not have, a joint twice, counts of names and values that
/// differ, no joint at all, a value that is not finite.
[[nodiscard]] Result<simulate::ArmCommand> from_message(const baxter_core_msgs::JointCommand& message,
                                                        simulate::Side side);

[[nodiscard]] baxter_core_msgs::AssemblyState to_message(const simulate::RobotState& state);
[[nodiscard]] sensor_msgs::JointState to_message(const simulate::JointSample& sample, const ros::Time& stamp);
[[nodiscard]] baxter_core_msgs::EndpointState endpoint_message(const simulate::ArmState& state,
                                                               const ros::Time& stamp);
/// Commanded velocity, acceleration and effort, hysteresis and crosstalk are not modelled: 0.
[[nodiscard]] baxter_core_msgs::SEAJointState torques_message(const simulate::ArmState& state,
                                                              simulate::Side side, const ros::Time& stamp);

}  // namespace extperfc::ros_robot
