#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <string>
#include <utility>

#include <actionlib/server/simple_action_server.h>
#include <ros/console.h>
#include <ros/node_handle.h>

#include "ros/arm/motion_callbacks.hpp"
#include "ros/arm/status.hpp"
#include "ros/convert/arm.hpp"

namespace extperfc::ros_arm {

/// An action server that executes its goals one after the other in a separate thread; a newer goal preempts.
/// Results need `code` and `message`, feedback `stage`.
template <typename Action>
class ActionRunner {
 public:
  using Server = actionlib::SimpleActionServer<Action>;
  using Goal = typename Server::GoalConstPtr::element_type;
  using Result = typename Action::_action_result_type::_result_type;
  using Feedback = typename Action::_action_feedback_type::_feedback_type;
  /// Fills the result except for code and message. The callbacks' cancel token covers cancelling and
  /// preemption.
  using Work = std::function<Status(const Goal& goal, const MotionCallbacks& callbacks, Result& result)>;

  ActionRunner(const ros::NodeHandle& handle, const std::string& name, Work work)
      : work_(std::move(work)),
        server_(
            handle, name, [this](const typename Server::GoalConstPtr& goal) { run(*goal); }, false) {
    server_.start();
  }
  /// Cancels the running goal.
  ~ActionRunner() {
    closing_ = true;
    try {
      server_.shutdown();
    } catch (const std::exception& error) {
      ROS_ERROR_STREAM("action server does not shut down: " << error.what());
    }
  }
  ActionRunner(const ActionRunner&) = delete;
  ActionRunner& operator=(const ActionRunner&) = delete;

 private:
  [[nodiscard]] std::optional<Status> cancel_reason() {
    using arm::ArmCode;
    if (closing_) return Status{ArmCode::kCancelled, "the node shuts down"};
    if (!server_.isPreemptRequested()) return std::nullopt;
    if (server_.isNewGoalAvailable()) return Status{ArmCode::kPreempted, "preempted by a newer goal"};
    return Status{ArmCode::kCancelled, "cancelled"};
  }

  void report(const std::string& stage, double executed) {
    Feedback feedback;
    feedback.stage = stage;
    set_executed(feedback, executed, 0);
    server_.publishFeedback(feedback);
  }
  template <typename Message>
  static auto set_executed(Message& message, double executed, int) -> decltype(message.executed, void()) {
    message.executed = executed;
  }
  template <typename Message>
  static void set_executed(Message&, double, long) {}

  void run(const Goal& goal) {
    Result result;
    Status status;
    MotionCallbacks callbacks;
    callbacks.cancel.add([this] { return cancel_reason(); });
    callbacks.progress = [this](const std::string& stage, double executed) { report(stage, executed); };
    try {
      status = work_(goal, callbacks, result);
    } catch (const std::exception& error) {
      status = {arm::ArmCode::kInternal, error.what()};
    }
    result.code = ros_convert::to_message(status.code);
    result.message = status.message;
    const std::string text = std::string(to_string(status.code)) + ": " + status.message;
    if (status.code == arm::ArmCode::kSuccess)
      server_.setSucceeded(result, text);
    else if (server_.isPreemptRequested())
      server_.setPreempted(result, text);
    else
      server_.setAborted(result, text);
  }

  Work work_;
  std::atomic<bool> closing_{false};
  Server server_;
};

}  // namespace extperfc::ros_arm
