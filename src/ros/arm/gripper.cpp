#include "ros/arm/gripper.hpp"

namespace extperfc::ros_arm {

using arm::ArmCode;

namespace {

constexpr double kOpen = 100.0, kClosed = 0.0;  // [%]
/// Empty fingers close to less than this [%].
constexpr double kNothing = 3.0;

}  // namespace

Gripper::Gripper(const ros::NodeHandle& handle, const std::string& action, const Params& params)
    : action_(action), params_(params) {
  ros::NodeHandle own(handle);  // the client wants to change it
  client_ = std::make_unique<Client>(own, action, false);
}

tl::expected<void, Status> Gripper::open(const MotionCallbacks& callbacks) {
  const auto result = move(kOpen, callbacks);
  if (!result) return tl::unexpected(result.error());
  return {};
}

tl::expected<bool, Status> Gripper::close(const MotionCallbacks& callbacks) {
  const auto result = move(kClosed, callbacks);
  if (!result) return tl::unexpected(result.error());
  return result->stalled != 0 && result->position > kNothing;
}

tl::expected<control_msgs::GripperCommandResult, Status> Gripper::move(double percent,
                                                                       const MotionCallbacks& callbacks) {
  const auto until = ros::WallTime::now() + ros::WallDuration(params_.timeout_s);
  const auto late = [&] { return ros::WallTime::now() > until || !ros::ok(); };
  const auto failed = [&](const std::string& why) {
    return failure(ArmCode::kGripperFailed, action_ + ": " + why);
  };
  while (!client_->isServerConnected()) {
    if (late()) return failed("no action server: is an electric gripper mounted and its driver running?");
    ros::WallDuration(0.02).sleep();
  }
  control_msgs::GripperCommandGoal goal;
  goal.command.position = percent;
  goal.command.max_effort = params_.effort_percent;
  client_->sendGoal(goal);
  while (!client_->getState().isDone()) {
    auto reason = callbacks.cancel.reason();
    if (!reason && late()) reason = Status{ArmCode::kGripperFailed, action_ + ": the motion does not finish"};
    if (reason) {
      client_->cancelGoal();
      return tl::unexpected(*reason);
    }
    ros::WallDuration(0.01).sleep();
  }
  if (client_->getState() != actionlib::SimpleClientGoalState::SUCCEEDED)
    return failed("ended as " + client_->getState().toString() + " " + client_->getState().getText());
  return *client_->getResult();
}

}  // namespace extperfc::ros_arm
