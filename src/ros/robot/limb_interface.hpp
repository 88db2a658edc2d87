#pragma once

#include <functional>
#include <string>

#include <baxter_core_msgs/JointCommand.h>
#include <ros/node_handle.h>
#include <std_msgs/Float64.h>
#include <trajectory_msgs/JointTrajectoryPoint.h>

#include "ros/robot/arm_motion.hpp"
#include "ros/robot/complaints.hpp"
#include "ros/simulate/sim_host.hpp"
#include "ros/simulate/ticker.hpp"

namespace extperfc::ros_robot {

/// One arm's topics.
///
/// Subscribes:
///   robot/limb/<side>/joint_command             baxter_core_msgs/JointCommand, of any of the arm's joints;
///                                               it ends an active trajectory
///   robot/limb/<side>/set_speed_ratio           std_msgs/Float64, [0, 1]
///   robot/limb/<side>/joint_command_timeout     std_msgs/Float64 [s], (0, 1]
///   robot/limb/<side>/inverse_dynamics_command  trajectory_msgs/JointTrajectoryPoint: accepted as on Baxter,
///                                               without effect: the simulated drives know their own dynamics
/// Publishes:
///   robot/limb/<side>/endpoint_state                baxter_core_msgs/EndpointState, in the frame `base`
///   robot/limb/<side>/gravity_compensation_torques  baxter_core_msgs/SEAJointState
class LimbInterface {
 public:
  LimbInterface(ros::NodeHandle handle, ros_simulate::SimHost& host, simulate::Side side, ArmMotion& motion,
                double rate_hz);

  void after_step(const simulate::Simulator& simulator, const ros::Time& stamp);

 private:
  void on_command(const baxter_core_msgs::JointCommandConstPtr& message);
  void on_speed_ratio(const std_msgs::Float64ConstPtr& message);
  void on_timeout(const std_msgs::Float64ConstPtr& message);
  void drive(simulate::Simulator& simulator, const simulate::ArmCommand& command);
  void refuse(const std::string& leaf, const std::string& why);
  void hand_over(const std::string& leaf, std::function<void(simulate::Simulator&)> work);

  ros_simulate::SimHost& host_;
  const simulate::Side side_;
  ArmMotion& motion_;
  ros_simulate::Ticker ticker_;
  Complaints complaints_;
  ros::Publisher endpoint_publisher_;
  ros::Publisher torques_publisher_;
  ros::Subscriber command_subscriber_;
  ros::Subscriber speed_ratio_subscriber_;
  ros::Subscriber timeout_subscriber_;
  ros::Subscriber dynamics_subscriber_;
};

}  // namespace extperfc::ros_robot
