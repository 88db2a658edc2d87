#pragma once

#include <string>

#include <geometry_msgs/PoseStamped.h>
#include <ros/time.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include "extperfc/arm/robot_arms.hpp"
#include "extperfc/world/pose.hpp"

#include "ros/arm/robot_state_monitor.hpp"
#include "ros/arm/status.hpp"

namespace extperfc::ros_arm {

/// Poses of frames in the frame of the robot's root link. Thread-safe.
class TransformLookup {
 public:
  /// Keeps the references.
  TransformLookup(const arm::RobotArms& arms, const RobotStateMonitor& robot_state, double timeout_s)
      : arms_(arms), robot_state_(robot_state), timeout_s_(timeout_s) {}

  /// root_T_frame at `stamp`; 0: now. Links of the robot at stamp 0 need no tf, but the joint states. An
  /// empty frame is the root. Errors: kUnknownFrame, kNoJointStates.
  [[nodiscard]] tl::expected<Pose, Status> root_T_frame(const std::string& frame,
                                                        const ros::Time& stamp) const;
  /// Errors: also kInvalidRequest for an invalid pose.
  [[nodiscard]] tl::expected<Pose, Status> root_T_pose(const geometry_msgs::PoseStamped& pose) const;

  [[nodiscard]] bool is_link(const std::string& frame) const { return arms_.robot().link(frame).has_value(); }

 private:
  const arm::RobotArms& arms_;
  const RobotStateMonitor& robot_state_;
  const double timeout_s_;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_{buffer_};
};

}  // namespace extperfc::ros_arm
