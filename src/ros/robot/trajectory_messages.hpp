#pragma once

#include <string>
#include <vector>

#include <control_msgs/FollowJointTrajectoryFeedback.h>
#include <control_msgs/FollowJointTrajectoryGoal.h>
#include <control_msgs/FollowJointTrajectoryResult.h>

#include "extperfc/simulate/joint_spline.hpp"
#include "extperfc/simulate/trajectory_goal.hpp"

/// control_msgs/FollowJointTrajectory <-> the follower's types.
namespace extperfc::ros_robot {

/// A stamp of zero starts at once. Efforts are left out: positions are what is followed.
[[nodiscard]] simulate::TrajectoryGoal from_message(const control_msgs::FollowJointTrajectoryGoal& message);
[[nodiscard]] control_msgs::FollowJointTrajectoryResult to_message(const simulate::TrajectoryEnd& end);
/// error = desired - actual.
[[nodiscard]] control_msgs::FollowJointTrajectoryFeedback feedback_message(
    const std::vector<simulate::FollowedJoint>& joints, const simulate::JointMotion& desired,
    const simulate::JointMotion& actual, const ros::Time& stamp);

}  // namespace extperfc::ros_robot
