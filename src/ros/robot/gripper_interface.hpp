#pragma once

#include <baxter_core_msgs/EndEffectorCommand.h>
#include <baxter_core_msgs/EndEffectorProperties.h>
#include <ros/node_handle.h>

#include "ros/robot/complaints.hpp"
#include "ros/simulate/sim_host.hpp"
#include "ros/simulate/ticker.hpp"

namespace extperfc::ros_robot {

/// One electric gripper's topics.
///
/// Subscribes:
///   robot/end_effector/<side>_gripper/command              baxter_core_msgs/EndEffectorCommand
///   robot/end_effector/<side>_gripper/rsdk/set_properties  baxter_core_msgs/EndEffectorProperties: what
///                                                          `properties` says from now on
/// Publishes:
///   robot/end_effector/<side>_gripper/state       baxter_core_msgs/EndEffectorState; command, command_sender
///                                                 and command_sequence are those of the last accepted
///                                                 command
///   robot/end_effector/<side>_gripper/properties  baxter_core_msgs/EndEffectorProperties, latched
class GripperInterface {
 public:
  GripperInterface(ros::NodeHandle handle, ros_simulate::SimHost& host, simulate::Side side, double rate_hz);

  void after_step(const simulate::Simulator& simulator, const ros::Time& stamp);

 private:
  void on_command(const baxter_core_msgs::EndEffectorCommandConstPtr& message);
  void on_properties(const baxter_core_msgs::EndEffectorPropertiesConstPtr& message);
  void refuse(const std::string& why);

  ros_simulate::SimHost& host_;
  const simulate::Side side_;
  ros_simulate::Ticker ticker_;
  Complaints complaints_;
  baxter_core_msgs::EndEffectorCommandConstPtr last_;  ///< that was taken; of the simulation thread
  ros::Publisher state_publisher_;
  ros::Publisher properties_publisher_;
  ros::Subscriber properties_subscriber_;
  ros::Subscriber command_subscriber_;
};

}  // namespace extperfc::ros_robot
