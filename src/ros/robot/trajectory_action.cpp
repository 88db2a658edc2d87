#include "ros/robot/trajectory_action.hpp"

#include <utility>

#include "ros/robot/names.hpp"
#include "ros/robot/trajectory_messages.hpp"

namespace extperfc::ros_robot {

using actionlib_msgs::GoalStatus;
using simulate::TrajectoryCode;
using simulate::TrajectoryEnd;

TrajectoryAction::TrajectoryAction(const ros::NodeHandle& handle, ros_simulate::SimHost& host,
                                   simulate::Side side, ArmMotion& motion, double feedback_rate_hz)
    : host_(host),
      motion_(motion),
      ticker_(feedback_rate_hz),
      server_(
          handle, limb_name(side, "follow_joint_trajectory"), [this](const Goal& goal) { on_goal(goal); },
          [this](const Goal& goal) { on_cancel(goal); }, false) {
  server_.start();
}

void TrajectoryAction::on_goal(const Goal& goal) {
  if (host_.post([this, goal](simulate::Simulator& simulator) { begin(goal, simulator); })) return;
  const TrajectoryEnd end{TrajectoryCode::kInvalidGoal, "the simulation accepts no commands now"};
  Goal(goal).setRejected(to_message(end), end.message);
}

void TrajectoryAction::on_cancel(const Goal& goal) {
  // A goal that waits to begin() sees there that it is recalled.
  (void)host_.post([this, goal](simulate::Simulator&) {
    if (active_ && *active_ == goal) motion_.stop();
  });
}

void TrajectoryAction::begin(Goal goal, const simulate::Simulator& simulator) {
  if (goal.getGoalStatus().status == GoalStatus::RECALLING) {
    const TrajectoryEnd recalled{TrajectoryCode::kGoalToleranceViolated, "cancelled before it began"};
    return goal.setCanceled(to_message(recalled), recalled.message);
  }
  const auto started = motion_.start(
      simulator, from_message(*goal.getGoal()),
      [this, goal](ArmMotion::Status status, const TrajectoryEnd& why) { end(goal, status, why); });
  if (!started) return goal.setRejected(to_message(started.error()), started.error().message);
  goal.setAccepted();
  active_ = goal;
}

void TrajectoryAction::end(Goal goal, ArmMotion::Status status, const TrajectoryEnd& end) {
  if (active_ && *active_ == goal) active_.reset();
  const auto result = to_message(end);
  switch (status) {
    case ArmMotion::Status::kReached:
      return goal.setSucceeded(result, end.message);
    case ArmMotion::Status::kFailed:
      return goal.setAborted(result, end.message);
    case ArmMotion::Status::kStopped:
    case ArmMotion::Status::kReplaced:
      return goal.setCanceled(result, end.message);
  }
}

void TrajectoryAction::after_step(const ros::Time& stamp) {
  if (!active_ || !ticker_.due(stamp.toSec())) return;
  const auto* follower = motion_.follower();
  active_->publishFeedback(
      feedback_message(follower->joints(), follower->desired(stamp.toSec()), follower->measured(), stamp));
}

}  // namespace extperfc::ros_robot
