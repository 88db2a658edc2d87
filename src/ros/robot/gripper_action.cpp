#include "ros/robot/gripper_action.hpp"

#include <cmath>
#include <utility>

#include "ros/robot/names.hpp"

namespace extperfc::ros_robot {

using actionlib_msgs::GoalStatus;
using control_msgs::GripperCommandResult;
using simulate::GripperCommand;
using Kind = GripperCommand::Kind;

namespace {

/// Fingers that have just been commanded do not move yet [s].
constexpr double kReactionTime = 0.05;

GripperCommand make(Kind kind) {
  GripperCommand command;
  command.kind = kind;
  return command;
}

Result<GripperCommand> from_message(const control_msgs::GripperCommand& message) {
  if (!(message.position >= 0 && message.position <= 100))
    return fail(ErrorCode::kInvalidArgument, "position is per cent: use 0 (closed) to 100 (open)");
  if (std::isnan(message.max_effort) || message.max_effort > 100)
    return fail(ErrorCode::kInvalidArgument,
                "max_effort is per cent: use up to 100, or 0 for the configured force");
  auto command = make(Kind::kGoTo);
  command.position_percent = message.position;
  if (message.max_effort > 0)
    command.moving_force_percent = command.holding_force_percent = message.max_effort;
  return command;
}

}  // namespace

GripperAction::GripperAction(const ros::NodeHandle& handle, ros_simulate::SimHost& host, simulate::Side side,
                             const GripperActionParams& params)
    : host_(host),
      side_(side),
      params_(params),
      ticker_(params.feedback_rate_hz),
      server_(
          handle, gripper_name(side, "gripper_action"), [this](const Goal& goal) { on_goal(goal); },
          [this](const Goal& goal) { on_cancel(goal); }, false) {
  server_.start();
}

void GripperAction::on_goal(const Goal& goal) {
  if (!host_.post([this, goal](simulate::Simulator& simulator) { begin(goal, simulator); }))
    Goal(goal).setRejected({}, "the simulation accepts no commands now");
}

void GripperAction::on_cancel(const Goal& goal) {
  (void)host_.post([this, goal](simulate::Simulator& simulator) { cancel(goal, simulator); });
}

void GripperAction::begin(Goal goal, simulate::Simulator& simulator) {
  if (goal.getGoalStatus().status == GoalStatus::RECALLING)
    return goal.setCanceled(result(simulator, goal), "cancelled before it began");
  const auto command = from_message(goal.getGoal()->command);
  if (!command) return goal.setRejected(result(simulator, goal), command.error().message);
  const bool calibrated = simulator.gripper_state(side_).calibrated;
  if (auto taken = simulator.command_gripper(side_, calibrated ? *command : make(Kind::kCalibrate)); !taken)
    return goal.setRejected(result(simulator, goal), taken.error().message);
  if (active_) active_->setCanceled(result(simulator, *active_), "a newer goal took the gripper");
  goal.setAccepted();
  active_ = goal;
  waiting_ = calibrated ? std::nullopt : std::optional(*command);
  begun_s_.reset();
}

void GripperAction::go_when_calibrated(const simulate::Simulator& simulator) {
  if (!simulator.gripper_state(side_).calibrated) return;
  const bool posted = host_.post([this, command = *waiting_, goal = *active_](simulate::Simulator& now) {
    if (active_ && *active_ == goal)
      (void)now.command_gripper(side_, command);  // judge() sees what comes of it
  });
  if (!posted) return;  // the next step tries again
  waiting_.reset();
  begun_s_.reset();
}

void GripperAction::cancel(Goal goal, simulate::Simulator& simulator) {
  if (!active_ || !(*active_ == goal)) return;
  (void)simulator.command_gripper(side_, make(Kind::kStop));  // a disabled gripper stands still already
  active_.reset();
  goal.setCanceled(result(simulator, goal), "cancelled during the motion");
}

GripperCommandResult GripperAction::result(const simulate::Simulator& simulator, const Goal& goal) const {
  const auto state = simulator.gripper_state(side_);
  GripperCommandResult message;
  message.position = state.position_percent;
  message.effort = state.force_percent;
  message.stalled = state.gripping;
  message.reached_goal =
      std::abs(state.position_percent - goal.getGoal()->command.position) <= params_.tolerance_percent;
  return message;
}

void GripperAction::after_step(const simulate::Simulator& simulator, const ros::Time& stamp) {
  if (!active_) return;
  const double time_s = stamp.toSec();
  if (!begun_s_ || time_s < *begun_s_) begun_s_ = time_s;
  const auto now = result(simulator, *active_);
  if (ticker_.due(time_s)) {
    control_msgs::GripperCommandFeedback feedback;
    feedback.position = now.position;
    feedback.effort = now.effort;
    feedback.stalled = now.stalled;
    feedback.reached_goal = now.reached_goal;
    active_->publishFeedback(feedback);
  }
  judge(now, simulator, time_s);
  if (active_ && waiting_) go_when_calibrated(simulator);
}

void GripperAction::judge(const GripperCommandResult& now, const simulate::Simulator& simulator,
                          double time_s) {
  const double passed_s = time_s - *begun_s_;
  const auto take = [this] { return *std::exchange(active_, std::nullopt); };
  if (!simulator.robot_state().enabled) return take().setAborted(now, "the robot is disabled or stopped");
  if (!waiting_ && passed_s >= kReactionTime && (now.reached_goal || now.stalled))
    return take().setSucceeded(now);
  if (passed_s >= params_.timeout_s)
    take().setAborted(now, "neither reached nor holding something in time: is a finger stuck?");
}

}  // namespace extperfc::ros_robot
