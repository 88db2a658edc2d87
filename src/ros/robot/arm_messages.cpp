#include "ros/robot/arm_messages.hpp"

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "ros/robot/names.hpp"

namespace extperfc::ros_robot {

namespace {

using baxter_core_msgs::AssemblyState;
using baxter_core_msgs::JointCommand;
using simulate::ArmMode;
using simulate::kArmJoints;
using Stop = simulate::RobotState::Stop;

std::optional<ArmMode> mode_from(std::int32_t mode) {
  switch (mode) {
    case JointCommand::POSITION_MODE:
      return ArmMode::kPosition;
    case JointCommand::VELOCITY_MODE:
      return ArmMode::kVelocity;
    case JointCommand::TORQUE_MODE:
      return ArmMode::kTorque;
    case JointCommand::RAW_POSITION_MODE:
      return ArmMode::kRawPosition;
    default:
      return std::nullopt;
  }
}

std::optional<int> joint_index(const std::string& name, simulate::Side side) {
  for (int i = 0; i < kArmJoints; ++i)
    if (name == joint_name(side, i)) return i;
  return std::nullopt;
}

std::vector<double> to_list(const simulate::ArmValues& values) {
  return {values.begin(), values.end()};
}

}  // namespace

Result<simulate::ArmCommand> from_message(const JointCommand& message, simulate::Side side) {
  const auto refuse = [](const std::string& what) { return fail(ErrorCode::kInvalidArgument, what); };
  simulate::ArmCommand command;
  const auto mode = mode_from(message.mode);
  if (!mode)
    return refuse("mode " + std::to_string(message.mode) +
                  " is unknown: use 1 (position), 2 (velocity), 3 (torque) or 4 (raw position)");
  command.mode = *mode;
  if (message.names.empty()) return refuse("no joint is named");
  if (message.names.size() != message.command.size())
    return refuse("it has " + std::to_string(message.names.size()) + " names and " +
                  std::to_string(message.command.size()) + " values; give one value per name");
  for (std::size_t i = 0; i < message.names.size(); ++i) {
    const auto joint = joint_index(message.names[i], side);
    if (!joint)
      return refuse("'" + message.names[i] + "' is not a joint of this arm; its joints are " +
                    joint_name(side, 0) + " to " + joint_name(side, kArmJoints - 1));
    if (command.values[*joint]) return refuse(message.names[i] + " is given twice");
    if (!std::isfinite(message.command[i]))
      return refuse(message.names[i] + " has a value that is not finite");
    command.values[*joint] = message.command[i];
  }
  return command;
}

AssemblyState to_message(const simulate::RobotState& state) {
  AssemblyState message;
  message.ready = state.ready;
  message.enabled = state.enabled;
  message.stopped = state.stopped;
  message.error = state.error;
  switch (state.source) {
    case Stop::kNone:
      message.estop_button = AssemblyState::ESTOP_BUTTON_UNPRESSED;
      message.estop_source = AssemblyState::ESTOP_SOURCE_NONE;
      break;
    case Stop::kUnknown:
      message.estop_button = AssemblyState::ESTOP_BUTTON_UNKNOWN;
      message.estop_source = AssemblyState::ESTOP_SOURCE_UNKNOWN;
      break;
    case Stop::kButton:  // a simulated button is never held, so a reset may follow
      message.estop_button = AssemblyState::ESTOP_BUTTON_RELEASED;
      message.estop_source = AssemblyState::ESTOP_SOURCE_USER;
      break;
    case Stop::kFault:
      message.estop_button = AssemblyState::ESTOP_BUTTON_UNKNOWN;
      message.estop_source = AssemblyState::ESTOP_SOURCE_FAULT;
      break;
  }
  return message;
}

sensor_msgs::JointState to_message(const simulate::JointSample& sample, const ros::Time& stamp) {
  sensor_msgs::JointState message;
  message.header.stamp = stamp;
  message.name = sample.names;
  message.position = sample.position;
  message.velocity = sample.velocity;
  message.effort = sample.effort;
  return message;
}

baxter_core_msgs::EndpointState endpoint_message(const simulate::ArmState& state, const ros::Time& stamp) {
  baxter_core_msgs::EndpointState message;
  message.header.stamp = stamp;
  message.header.frame_id = kBaseFrame;
  const auto set = [](auto& to, const auto& from) {
    to.x = from.x();
    to.y = from.y();
    to.z = from.z();
  };
  set(message.pose.position, state.base_T_endpoint.translation());
  const Eigen::Quaterniond rotation(state.base_T_endpoint.rotation());
  set(message.pose.orientation, rotation);
  message.pose.orientation.w = rotation.w();
  set(message.twist.linear, state.twist.head<3>());
  set(message.twist.angular, state.twist.tail<3>());
  set(message.wrench.force, state.wrench.head<3>());
  set(message.wrench.torque, state.wrench.tail<3>());
  return message;
}

baxter_core_msgs::SEAJointState torques_message(const simulate::ArmState& state, simulate::Side side,
                                                const ros::Time& stamp) {
  baxter_core_msgs::SEAJointState message;
  message.header.stamp = stamp;
  message.header.frame_id = kBaseFrame;
  for (int i = 0; i < kArmJoints; ++i) message.name.push_back(joint_name(side, i));
  const std::vector<double> none(kArmJoints, 0.0);
  message.commanded_position = to_list(state.command);
  message.commanded_velocity = none;
  message.commanded_acceleration = none;
  message.commanded_effort = none;
  message.actual_position = to_list(state.position);
  message.actual_velocity = to_list(state.velocity);
  message.actual_effort = to_list(state.effort);
  message.gravity_model_effort = to_list(state.gravity);
  message.gravity_only = to_list(state.gravity);
  message.hysteresis_model_effort = none;
  message.crosstalk_model_effort = none;
  return message;
}

}  // namespace extperfc::ros_robot
