#pragma once

#include <baxter_core_msgs/HeadPanCommand.h>
#include <ros/node_handle.h>
#include <std_msgs/Bool.h>

#include "ros/robot/complaints.hpp"
#include "ros/simulate/sim_host.hpp"
#include "ros/simulate/ticker.hpp"

namespace extperfc::ros_robot {

/// The head rotates about the vertical axis, and nods.
///
/// Subscribes:
///   robot/head/command_head_pan  baxter_core_msgs/HeadPanCommand; enable_pan_request switches the pan motor:
///                                while it is off, targets are ignored
///   robot/head/command_head_nod  std_msgs/Bool; true: nod once
/// Publishes:
///   robot/head/head_state  baxter_core_msgs/HeadState
class HeadInterface {
 public:
  HeadInterface(ros::NodeHandle handle, ros_simulate::SimHost& host, double rate_hz);

  void after_step(const simulate::Simulator& simulator, const ros::Time& stamp);

 private:
  void on_pan(const baxter_core_msgs::HeadPanCommandConstPtr& message);
  void on_nod(const std_msgs::BoolConstPtr& message);
  void pan(simulate::Simulator& simulator, const baxter_core_msgs::HeadPanCommand& command);

  ros_simulate::SimHost& host_;
  ros_simulate::Ticker ticker_;
  Complaints complaints_;
  bool pan_motor_{true};  ///< of the simulation thread
  ros::Publisher publisher_;
  ros::Subscriber pan_subscriber_;
  ros::Subscriber nod_subscriber_;
};

}  // namespace extperfc::ros_robot
