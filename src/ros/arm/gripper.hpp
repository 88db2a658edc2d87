#pragma once

#include <memory>
#include <string>

#include <actionlib/client/simple_action_client.h>
#include <control_msgs/GripperCommandAction.h>
#include <ros/node_handle.h>

#include "ros/arm/executor.hpp"
#include "ros/arm/status.hpp"

namespace extperfc::ros_arm {

/// The action of a gripper; positions in per cent of the opening.
class Gripper {
 public:
  struct Params {
    double effort_percent{0};
    double timeout_s{10};  ///< of wall time, for an answer of the server and for the motion
  };
  Gripper(const ros::NodeHandle& handle, const std::string& action, const Params& params);

  /// Errors: kGripperFailed, or the reason of `callbacks.cancel`.
  [[nodiscard]] tl::expected<void, Status> open(const MotionCallbacks& callbacks);
  /// True when an object is between the fingers. Errors as open().
  [[nodiscard]] tl::expected<bool, Status> close(const MotionCallbacks& callbacks);

 private:
  using Client = actionlib::SimpleActionClient<control_msgs::GripperCommandAction>;
  [[nodiscard]] tl::expected<control_msgs::GripperCommandResult, Status> move(
      double percent, const MotionCallbacks& callbacks);

  const std::string action_;
  const Params params_;
  std::unique_ptr<Client> client_;
};

}  // namespace extperfc::ros_arm
