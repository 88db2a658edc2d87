#pragma once

#include <ros/node_handle.h>
#include <std_msgs/UInt16.h>

#include "ros/robot/complaints.hpp"
#include "ros/simulate/sim_host.hpp"
#include "ros/simulate/ticker.hpp"

namespace extperfc::ros_robot {

/// Every joint that moves, wheels and fingers included.
///
/// Subscribes:
///   robot/joint_state_publish_rate  std_msgs/UInt16 [Hz], 1 to 1000
/// Publishes:
///   robot/joint_states  sensor_msgs/JointState
class JointStatePublisher {
 public:
  JointStatePublisher(ros::NodeHandle handle, ros_simulate::SimHost& host, double rate_hz);

  void after_step(const simulate::Simulator& simulator, const ros::Time& stamp);

 private:
  void on_rate(const std_msgs::UInt16ConstPtr& message);

  ros_simulate::SimHost& host_;
  ros_simulate::Ticker ticker_;  ///< of the simulation thread
  Complaints complaints_;
  ros::Publisher publisher_;
  ros::Subscriber rate_subscriber_;
};

}  // namespace extperfc::ros_robot
