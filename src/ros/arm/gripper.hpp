#pragma once

#include <memory>
#include <string>

#include <actionlib/client/simple_action_client.h>
#include <control_msgs/GripperCommandAction.h>
#include <ros/node_handle.h>

#include "ros/arm/ending.hpp"
#include "ros/arm/executor.hpp"

namespace extperfc::arm_node {

/// The action of a gripper; positions in per cent of the opening.
class Gripper {
 public:
  struct Params {
    double effort_percent{0};
    double timeout_s{10};  ///< of wall time, for an answer of the server and for the motion
  };
  Gripper(const ros::NodeHandle& handle, const std::string& action, const Params& params);

  /// Ending: kGripperFailed, or what `hooks.interrupted` says.
  [[nodiscard]] tl::expected<void, Ending> open(const Hooks& hooks);
  /// Whether something is between the fingers.
  [[nodiscard]] tl::expected<bool, Ending> close(const Hooks& hooks);

 private:
  using Client = actionlib::SimpleActionClient<control_msgs::GripperCommandAction>;
  [[nodiscard]] tl::expected<control_msgs::GripperCommandResult, Ending> move(double percent,
                                                                              const Hooks& hooks);

  const std::string action_;
  const Params params_;
  std::unique_ptr<Client> client_;
};

}  // namespace extperfc::arm_node
