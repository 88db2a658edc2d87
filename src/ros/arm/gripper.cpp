#include "ros/arm/gripper.hpp"

namespace extperfc::arm_node {

using arm::ArmCode;

namespace {

constexpr double kOpen = 100.0, kClosed = 0.0;  // [%]
/// Fingers that hold nothing come nearer to each other than this [%].
constexpr double kNothing = 3.0;

}  // namespace

Gripper::Gripper(const ros::NodeHandle& handle, const std::string& action, const Params& params)
    : action_(action), params_(params) {
  ros::NodeHandle own(handle);  // the client wants to change it
  client_ = std::make_unique<Client>(own, action, false);
}

tl::expected<void, Ending> Gripper::open(const Hooks& hooks) {
  const auto result = move(kOpen, hooks);
  if (!result) return tl::unexpected(result.error());
  return {};
}

tl::expected<bool, Ending> Gripper::close(const Hooks& hooks) {
  const auto result = move(kClosed, hooks);
  if (!result) return tl::unexpected(result.error());
  return result->stalled != 0 && result->position > kNothing;
}

tl::expected<control_msgs::GripperCommandResult, Ending> Gripper::move(double percent, const Hooks& hooks) {
  const auto until = ros::WallTime::now() + ros::WallDuration(params_.timeout_s);
  const auto late = [&] { return ros::WallTime::now() > until || !ros::ok(); };
  const auto failed = [&](const std::string& why) {
    return end(ArmCode::kGripperFailed, action_ + ": " + why);
  };
  while (!client_->isServerConnected()) {
    if (late()) return failed("nobody answers: is there an electric gripper?");
    ros::WallDuration(0.02).sleep();
  }
  control_msgs::GripperCommandGoal goal;
  goal.command.position = percent;
  goal.command.max_effort = params_.effort_percent;
  client_->sendGoal(goal);
  while (!client_->getState().isDone()) {
    std::optional<Ending> why;
    if (hooks.interrupted) why = hooks.interrupted();
    if (!why && late()) why = Ending{ArmCode::kGripperFailed, action_ + ": it does not come to an end"};
    if (why) {
      client_->cancelGoal();
      return tl::unexpected(*why);
    }
    ros::WallDuration(0.01).sleep();
  }
  if (client_->getState() != actionlib::SimpleClientGoalState::SUCCEEDED)
    return failed("ended as " + client_->getState().toString() + " " + client_->getState().getText());
  return *client_->getResult();
}

}  // namespace extperfc::arm_node
