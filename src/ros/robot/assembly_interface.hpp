#pragma once

#include <ros/node_handle.h>
#include <std_msgs/Bool.h>
#include <std_msgs/Empty.h>

#include "ros/robot/complaints.hpp"
#include "ros/simulate/sim_host.hpp"
#include "ros/simulate/ticker.hpp"

namespace extperfc::ros_robot {

/// The robot as a whole: switched on, off, stopped in an emergency and reset after it.
///
/// Subscribes:
///   robot/set_super_enable  std_msgs/Bool; refused while stopped
///   robot/set_super_stop    std_msgs/Empty: emergency stop
///   robot/set_super_reset   std_msgs/Empty: takes the emergency stop back; the robot stays disabled
/// Publishes:
///   robot/state  baxter_core_msgs/AssemblyState
class AssemblyInterface {
 public:
  AssemblyInterface(ros::NodeHandle handle, ros_simulate::SimHost& host, double rate_hz);

  void after_step(const simulate::Simulator& simulator, const ros::Time& stamp);

 private:
  void on_enable(const std_msgs::BoolConstPtr& message);
  void on_stop(const std_msgs::EmptyConstPtr& message);
  void on_reset(const std_msgs::EmptyConstPtr& message);
  void hand_over(const char* topic, std::function<void(simulate::Simulator&)> work);

  ros_simulate::SimHost& host_;
  ros_simulate::Ticker ticker_;
  Complaints complaints_;
  ros::Publisher publisher_;
  ros::Subscriber enable_subscriber_;
  ros::Subscriber stop_subscriber_;
  ros::Subscriber reset_subscriber_;
};

}  // namespace extperfc::ros_robot
