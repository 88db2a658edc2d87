#pragma once

#include <memory>

#include <ros/node_handle.h>

#include "ros/params/robot_interface_params.hpp"
#include "ros/simulate/sim_host.hpp"

namespace extperfc::ros_robot {

/// Baxter's ROS interface of a simulated robot: topics, actions and services under robot/, relative to the
/// handle's namespace and served by its callback queue.
///
/// Parts: JointStatePublisher, AssemblyInterface, HeadInterface, LimbInterface, TrajectoryAction,
///   GripperInterface, GripperAction, TuckService
/// Threads: callbacks may come from several threads; they check, and hand over to the simulation thread,
///   which has all of the state and publishes.
class RobotInterface {
 public:
  /// Make it before the simulation starts. `host` must outlive it, and its simulation thread must have ended
  /// before this ends.
  RobotInterface(const ros::NodeHandle& handle, ros_simulate::SimHost& host,
                 const ros_params::RobotInterfaceParams& params);
  ~RobotInterface();
  RobotInterface(const RobotInterface&) = delete;
  RobotInterface& operator=(const RobotInterface&) = delete;

 private:
  struct Arm;
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace extperfc::ros_robot
