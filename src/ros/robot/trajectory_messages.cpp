#include "ros/robot/trajectory_messages.hpp"

namespace extperfc::ros_robot {

namespace {

constexpr bool is(simulate::TrajectoryCode code, int constant) {
  return static_cast<int>(code) == constant;
}
static_assert(is(simulate::TrajectoryCode::kSuccessful,
                 control_msgs::FollowJointTrajectoryResult::SUCCESSFUL));
static_assert(is(simulate::TrajectoryCode::kInvalidGoal,
                 control_msgs::FollowJointTrajectoryResult::INVALID_GOAL));
static_assert(is(simulate::TrajectoryCode::kInvalidJoints,
                 control_msgs::FollowJointTrajectoryResult::INVALID_JOINTS));
static_assert(is(simulate::TrajectoryCode::kOldHeaderTimestamp,
                 control_msgs::FollowJointTrajectoryResult::OLD_HEADER_TIMESTAMP));
static_assert(is(simulate::TrajectoryCode::kPathToleranceViolated,
                 control_msgs::FollowJointTrajectoryResult::PATH_TOLERANCE_VIOLATED));
static_assert(is(simulate::TrajectoryCode::kGoalToleranceViolated,
                 control_msgs::FollowJointTrajectoryResult::GOAL_TOLERANCE_VIOLATED));

std::vector<simulate::JointTolerance> from_messages(
    const std::vector<control_msgs::JointTolerance>& messages) {
  std::vector<simulate::JointTolerance> tolerances;
  tolerances.reserve(messages.size());
  for (const auto& message : messages)
    tolerances.push_back({message.name, message.position, message.velocity, message.acceleration});
  return tolerances;
}

trajectory_msgs::JointTrajectoryPoint to_message(const simulate::JointMotion& motion) {
  trajectory_msgs::JointTrajectoryPoint message;
  message.positions.assign(motion.position.begin(), motion.position.end());
  message.velocities.assign(motion.velocity.begin(), motion.velocity.end());
  message.accelerations.assign(motion.acceleration.begin(), motion.acceleration.end());
  return message;
}

}  // namespace

simulate::TrajectoryGoal from_message(const control_msgs::FollowJointTrajectoryGoal& message) {
  simulate::TrajectoryGoal goal;
  goal.joints = message.trajectory.joint_names;
  for (const auto& point : message.trajectory.points)
    goal.points.push_back(
        {point.time_from_start.toSec(), point.positions, point.velocities, point.accelerations});
  if (!message.trajectory.header.stamp.isZero()) goal.start_s = message.trajectory.header.stamp.toSec();
  goal.path_tolerance = from_messages(message.path_tolerance);
  goal.goal_tolerance = from_messages(message.goal_tolerance);
  goal.goal_time_tolerance_s = message.goal_time_tolerance.toSec();
  return goal;
}

control_msgs::FollowJointTrajectoryResult to_message(const simulate::TrajectoryEnd& end) {
  control_msgs::FollowJointTrajectoryResult message;
  message.error_code = static_cast<std::int32_t>(end.code);
  message.error_string = end.message;
  return message;
}

control_msgs::FollowJointTrajectoryFeedback feedback_message(
    const std::vector<simulate::FollowedJoint>& joints, const simulate::JointMotion& desired,
    const simulate::JointMotion& actual, const ros::Time& stamp) {
  control_msgs::FollowJointTrajectoryFeedback message;
  message.header.stamp = stamp;
  for (const auto& joint : joints) message.joint_names.push_back(joint.name);
  message.desired = to_message(desired);
  message.actual = to_message(actual);
  message.error = to_message({desired.position - actual.position, desired.velocity - actual.velocity,
                              desired.acceleration - actual.acceleration});
  return message;
}

}  // namespace extperfc::ros_robot
