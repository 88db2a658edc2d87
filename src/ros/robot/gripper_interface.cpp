#include "ros/robot/gripper_interface.hpp"

#include <string>

#include "ros/robot/gripper_messages.hpp"
#include "ros/robot/names.hpp"

namespace extperfc::ros_robot {

using baxter_core_msgs::EndEffectorProperties;

GripperInterface::GripperInterface(ros::NodeHandle handle, ros_simulate::SimHost& host, simulate::Side side,
                                   double rate_hz)
    : host_(host), side_(side), ticker_(rate_hz) {
  const auto name = [side](const char* leaf) { return gripper_name(side, leaf); };
  state_publisher_ = handle.advertise<baxter_core_msgs::EndEffectorState>(name("state"), 10);
  properties_publisher_ = handle.advertise<EndEffectorProperties>(name("properties"), 1, true);
  properties_publisher_.publish(gripper_properties());
  properties_subscriber_ =
      handle.subscribe(name("rsdk/set_properties"), 1, &GripperInterface::on_properties, this);
  command_subscriber_ = handle.subscribe(name("command"), 10, &GripperInterface::on_command, this);
}

void GripperInterface::after_step(const simulate::Simulator& simulator, const ros::Time& stamp) {
  if (!ticker_.due(stamp.toSec()) || state_publisher_.getNumSubscribers() == 0) return;
  auto message = boost::make_shared<baxter_core_msgs::EndEffectorState>(
      to_message(simulator.gripper_state(side_), simulator.robot_state().enabled, stamp));
  if (last_) {
    message->command = last_->command;
    message->command_sender = last_->sender;
    message->command_sequence = last_->sequence;
  }
  state_publisher_.publish(message);
}

void GripperInterface::on_command(const baxter_core_msgs::EndEffectorCommandConstPtr& message) {
  const auto command = from_message(*message);
  if (!command) return refuse(command.error().message);
  const bool posted = host_.post([this, message, command = *command](simulate::Simulator& simulator) {
    if (auto taken = simulator.command_gripper(side_, command); !taken) return refuse(taken.error().message);
    last_ = message;
  });
  if (!posted) refuse("the simulation accepts no commands now");
}

void GripperInterface::on_properties(const baxter_core_msgs::EndEffectorPropertiesConstPtr& message) {
  if (message->ui_type > EndEffectorProperties::PASSIVE_GRIPPER)
    return complaints_.report(gripper_name(side_, "rsdk/set_properties") + " is ignored: ui_type " +
                              std::to_string(message->ui_type) + " must be 0 to 3");
  properties_publisher_.publish(message);
}

void GripperInterface::refuse(const std::string& why) {
  complaints_.report(gripper_name(side_, "command") + " is ignored: " + why);
}

}  // namespace extperfc::ros_robot
