#include "ros/robot/limb_interface.hpp"

#include <cmath>
#include <utility>

#include "ros/robot/arm_messages.hpp"
#include "ros/robot/names.hpp"

namespace extperfc::ros_robot {

LimbInterface::LimbInterface(ros::NodeHandle handle, ros_simulate::SimHost& host, simulate::Side side,
                             ArmMotion& motion, double rate_hz)
    : host_(host), side_(side), motion_(motion), ticker_(rate_hz) {
  const auto name = [side](const char* leaf) { return limb_name(side, leaf); };
  endpoint_publisher_ = handle.advertise<baxter_core_msgs::EndpointState>(name("endpoint_state"), 10);
  torques_publisher_ =
      handle.advertise<baxter_core_msgs::SEAJointState>(name("gravity_compensation_torques"), 10);
  speed_ratio_subscriber_ =
      handle.subscribe(name("set_speed_ratio"), 1, &LimbInterface::on_speed_ratio, this);
  timeout_subscriber_ = handle.subscribe(name("joint_command_timeout"), 1, &LimbInterface::on_timeout, this);
  const boost::function<void(const trajectory_msgs::JointTrajectoryPointConstPtr&)> ignore = [](const auto&) {
  };
  dynamics_subscriber_ =
      handle.subscribe<trajectory_msgs::JointTrajectoryPoint>(name("inverse_dynamics_command"), 1, ignore);
  command_subscriber_ = handle.subscribe(name("joint_command"), 10, &LimbInterface::on_command, this);
}

void LimbInterface::after_step(const simulate::Simulator& simulator, const ros::Time& stamp) {
  if (!ticker_.due(stamp.toSec())) return;
  const bool endpoint = endpoint_publisher_.getNumSubscribers() > 0;
  const bool torques = torques_publisher_.getNumSubscribers() > 0;
  if (!endpoint && !torques) return;
  const auto state = simulator.arm_state(side_);
  if (endpoint)
    endpoint_publisher_.publish(
        boost::make_shared<baxter_core_msgs::EndpointState>(endpoint_message(state, stamp)));
  if (torques)
    torques_publisher_.publish(
        boost::make_shared<baxter_core_msgs::SEAJointState>(torques_message(state, side_, stamp)));
}

void LimbInterface::on_command(const baxter_core_msgs::JointCommandConstPtr& message) {
  auto command = from_message(*message, side_);
  if (!command) return refuse("joint_command", command.error().message);
  hand_over("joint_command",
            [this, command = *command](simulate::Simulator& simulator) { drive(simulator, command); });
}

void LimbInterface::drive(simulate::Simulator& simulator, const simulate::ArmCommand& command) {
  if (!simulator.robot_state().enabled)
    return refuse("joint_command", "the robot is disabled: publish true on robot/set_super_enable");
  if (auto taken = simulator.command_arm(side_, command); !taken)
    return refuse("joint_command", taken.error().message);
  motion_.yield_arm("a command on " + limb_name(side_, "joint_command") + " took the arm");
}

void LimbInterface::on_speed_ratio(const std_msgs::Float64ConstPtr& message) {
  if (!(message->data >= 0 && message->data <= 1))
    return refuse("set_speed_ratio", "the ratio must be in [0, 1]");
  hand_over("set_speed_ratio", [this, ratio = message->data](simulate::Simulator& simulator) {
    simulator.set_speed_ratio(side_, ratio);
  });
}

void LimbInterface::on_timeout(const std_msgs::Float64ConstPtr& message) {
  if (!(message->data > 0 && message->data <= 1))
    return refuse("joint_command_timeout", "the time must be in (0, 1] s");
  hand_over("joint_command_timeout", [this, timeout_s = message->data](simulate::Simulator& simulator) {
    simulator.set_arm_timeout(side_, timeout_s);
  });
}

void LimbInterface::refuse(const std::string& leaf, const std::string& why) {
  complaints_.report(limb_name(side_, leaf) + " is ignored: " + why);
}

void LimbInterface::hand_over(const std::string& leaf, std::function<void(simulate::Simulator&)> work) {
  if (!host_.post(std::move(work))) refuse(leaf, "the simulation accepts no commands now");
}

}  // namespace extperfc::ros_robot
