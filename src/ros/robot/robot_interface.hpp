#pragma once

#include <memory>

#include <ros/node_handle.h>

#include "ros/params/robot_interface_params.hpp"
#include "ros/simulate/sim_host.hpp"

namespace extperfc {

/// Baxter's ROS interface of a simulated robot: topics, actions and services under robot/, relative to the
/// handle's namespace and served by its callback queue. docs of each part: its header.
///
///   robot/joint_states, robot/joint_state_publish_rate                     JointStatePublisher
///   robot/state, robot/set_super_{enable,stop,reset}                       AssemblyInterface
///   robot/head/...                                                         HeadInterface
///   robot/limb/<side>/{joint_command, endpoint_state, ...}                 LimbInterface
///   robot/limb/<side>/follow_joint_trajectory          action              TrajectoryAction
///   robot/end_effector/<side>_gripper/{command, state, properties, ...}    GripperInterface
///   robot/end_effector/<side>_gripper/gripper_action   action              GripperAction
///   robot/tuck_arms                                    service             TuckService
///
/// Threads: callbacks may come from several threads; they check, and hand over to the simulation thread,
/// which has all of the state and publishes.
class RobotInterface {
 public:
  /// Make it before the simulation starts. `host` must outlive it, and its simulation thread must have ended
  /// before this ends.
  RobotInterface(const ros::NodeHandle& handle, SimHost& host,
                 const ros_params::RobotInterfaceParams& params);
  ~RobotInterface();
  RobotInterface(const RobotInterface&) = delete;
  RobotInterface& operator=(const RobotInterface&) = delete;

 private:
  struct Arm;
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace extperfc
