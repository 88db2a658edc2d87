#pragma once

#include <string>

#include <geometry_msgs/PoseStamped.h>
#include <ros/time.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include "extperfc/arm/robot_arms.hpp"
#include "extperfc/world/pose.hpp"

#include "ros/arm/ending.hpp"
#include "ros/arm/robot_watch.hpp"

namespace extperfc::arm_node {

/// Where frames are in the frame of the robot's root link. Thread-safe.
class FrameFinder {
 public:
  /// References are kept.
  FrameFinder(const arm::RobotArms& arms, const RobotWatch& watch, double timeout_s)
      : arms_(arms), watch_(watch), timeout_s_(timeout_s) {}

  /// root_T_frame at `stamp`; 0: now. Links of the robot at stamp 0 need no tf: they are where the joint
  /// states say. An empty frame is the root. Endings: kUnknownFrame, kNoJointStates.
  [[nodiscard]] tl::expected<Pose, Ending> root_T_frame(const std::string& frame,
                                                        const ros::Time& stamp) const;
  /// Endings: also kInvalidRequest for what is no pose.
  [[nodiscard]] tl::expected<Pose, Ending> root_T_pose(const geometry_msgs::PoseStamped& pose) const;

  [[nodiscard]] bool is_link(const std::string& frame) const { return arms_.robot().link(frame).has_value(); }

 private:
  const arm::RobotArms& arms_;
  const RobotWatch& watch_;
  const double timeout_s_;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_{buffer_};
};

}  // namespace extperfc::arm_node
