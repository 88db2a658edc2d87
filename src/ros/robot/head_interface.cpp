#include "ros/robot/head_interface.hpp"

#include <cmath>

#include <baxter_core_msgs/HeadState.h>

namespace extperfc::ros_robot {

using baxter_core_msgs::HeadPanCommand;

HeadInterface::HeadInterface(ros::NodeHandle handle, ros_simulate::SimHost& host, double rate_hz)
    : host_(host), ticker_(rate_hz) {
  publisher_ = handle.advertise<baxter_core_msgs::HeadState>("robot/head/head_state", 10);
  pan_subscriber_ = handle.subscribe("robot/head/command_head_pan", 10, &HeadInterface::on_pan, this);
  nod_subscriber_ = handle.subscribe("robot/head/command_head_nod", 10, &HeadInterface::on_nod, this);
}

void HeadInterface::after_step(const simulate::Simulator& simulator, const ros::Time& stamp) {
  if (!ticker_.due(stamp.toSec()) || publisher_.getNumSubscribers() == 0) return;
  const auto state = simulator.head_state();
  auto message = boost::make_shared<baxter_core_msgs::HeadState>();
  message->pan = static_cast<float>(state.pan);
  message->isTurning = state.turning;
  message->isNodding = state.nodding;
  message->isPanEnabled = pan_motor_ && simulator.robot_state().enabled;
  publisher_.publish(message);
}

void HeadInterface::on_pan(const baxter_core_msgs::HeadPanCommandConstPtr& message) {
  if (!std::isfinite(message->target) || !std::isfinite(message->speed_ratio))
    return complaints_.report("robot/head/command_head_pan: target and speed_ratio must be finite: ignored");
  if (message->speed_ratio < HeadPanCommand::MIN_SPEED_RATIO ||
      message->speed_ratio > HeadPanCommand::MAX_SPEED_RATIO)
    return complaints_.report("robot/head/command_head_pan: speed_ratio is outside [0, 1]: ignored");
  if (!host_.post([this, message](simulate::Simulator& simulator) { pan(simulator, *message); }))
    complaints_.report("robot/head/command_head_pan: the simulation accepts no commands now");
}

void HeadInterface::pan(simulate::Simulator& simulator, const HeadPanCommand& command) {
  if (command.enable_pan_request == HeadPanCommand::REQUEST_PAN_ENABLE) pan_motor_ = true;
  if (command.enable_pan_request == HeadPanCommand::REQUEST_PAN_DISABLE) {
    pan_motor_ = false;
    simulator.command_head_pan(simulator.head_state().pan, 1.0);  // stays where it is
  }
  if (pan_motor_) simulator.command_head_pan(command.target, command.speed_ratio);
}

void HeadInterface::on_nod(const std_msgs::BoolConstPtr& message) {
  if (!message->data) return;
  if (!host_.post([](simulate::Simulator& simulator) { simulator.command_head_nod(); }))
    complaints_.report("robot/head/command_head_nod: the simulation accepts no commands now");
}

}  // namespace extperfc::ros_robot
