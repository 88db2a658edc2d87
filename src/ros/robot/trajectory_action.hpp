#pragma once

#include <optional>

#include <actionlib/server/action_server.h>
#include <control_msgs/FollowJointTrajectoryAction.h>
#include <ros/node_handle.h>

#include "ros/robot/arm_motion.hpp"
#include "ros/simulate/sim_host.hpp"
#include "ros/simulate/ticker.hpp"

namespace extperfc::ros_robot {

/// Follows trajectories. Goals that cannot be followed are rejected, with error_code and error_string in the
/// result. A newer goal takes the arm from an older one, which ends preempted; a cancelled goal slows down
/// and ends preempted at rest. Any other end of the motion (a tolerance, a joint command, a disabled or
/// stopped robot) aborts it. A preempted goal's error_code is GOAL_TOLERANCE_VIOLATED: the goal was not
/// reached.
///
/// Actions:
///   robot/limb/<side>/follow_joint_trajectory  control_msgs/FollowJointTrajectory
/// Threads: goals are handed to the simulation thread, which has all of the state.
class TrajectoryAction {
 public:
  TrajectoryAction(const ros::NodeHandle& handle, ros_simulate::SimHost& host, simulate::Side side,
                   ArmMotion& motion, double feedback_rate_hz);

  void after_step(const ros::Time& stamp);

 private:
  using Server = actionlib::ActionServer<control_msgs::FollowJointTrajectoryAction>;
  using Goal = Server::GoalHandle;

  void on_goal(const Goal& goal);
  void on_cancel(const Goal& goal);
  void begin(Goal goal, const simulate::Simulator& simulator);
  void end(Goal goal, ArmMotion::Status status, const simulate::TrajectoryEnd& end);

  ros_simulate::SimHost& host_;
  ArmMotion& motion_;
  ros_simulate::Ticker ticker_;
  std::optional<Goal> active_;
  Server server_;  // last: no callback comes after the rest is gone
};

}  // namespace extperfc::ros_robot
