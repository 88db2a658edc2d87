#include "ros/robot/assembly_interface.hpp"

#include <string>
#include <utility>

#include "ros/robot/arm_messages.hpp"

namespace extperfc::ros_robot {

AssemblyInterface::AssemblyInterface(ros::NodeHandle handle, ros_simulate::SimHost& host, double rate_hz)
    : host_(host), ticker_(rate_hz) {
  publisher_ = handle.advertise<baxter_core_msgs::AssemblyState>("robot/state", 10);
  enable_subscriber_ = handle.subscribe("robot/set_super_enable", 10, &AssemblyInterface::on_enable, this);
  stop_subscriber_ = handle.subscribe("robot/set_super_stop", 10, &AssemblyInterface::on_stop, this);
  reset_subscriber_ = handle.subscribe("robot/set_super_reset", 10, &AssemblyInterface::on_reset, this);
}

void AssemblyInterface::after_step(const simulate::Simulator& simulator, const ros::Time& stamp) {
  if (!ticker_.due(stamp.toSec()) || publisher_.getNumSubscribers() == 0) return;
  publisher_.publish(
      boost::make_shared<baxter_core_msgs::AssemblyState>(to_message(simulator.robot_state())));
}

void AssemblyInterface::on_enable(const std_msgs::BoolConstPtr& message) {
  hand_over("robot/set_super_enable", [this, on = message->data != 0](simulate::Simulator& simulator) {
    simulator.enable(on);
    if (on && !simulator.robot_state().enabled)
      complaints_.report(
          "robot/set_super_enable: the robot is stopped; publish on robot/set_super_reset first");
  });
}

void AssemblyInterface::on_stop(const std_msgs::EmptyConstPtr& /*message*/) {
  hand_over("robot/set_super_stop", [](simulate::Simulator& simulator) { simulator.stop(); });
}

void AssemblyInterface::on_reset(const std_msgs::EmptyConstPtr& /*message*/) {
  hand_over("robot/set_super_reset", [](simulate::Simulator& simulator) {
    if (simulator.robot_state().stopped || simulator.robot_state().error) simulator.reset_stop();
  });
}

void AssemblyInterface::hand_over(const char* topic, std::function<void(simulate::Simulator&)> work) {
  if (!host_.post(std::move(work)))
    complaints_.report(std::string(topic) + ": the simulation accepts no commands now");
}

}  // namespace extperfc::ros_robot
