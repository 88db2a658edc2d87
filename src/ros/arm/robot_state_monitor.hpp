#pragma once

#include <deque>
#include <mutex>
#include <optional>
#include <string>

#include <baxter_core_msgs/AssemblyState.h>
#include <ros/node_handle.h>
#include <sensor_msgs/JointState.h>

#include "extperfc/arm/arm_code.hpp"
#include "extperfc/arm/robot_arms.hpp"

#include "ros/arm/status.hpp"

namespace extperfc::ros_arm {

/// Joint positions and readiness of the robot, from robot/joint_states and robot/state.
/// Thread-safe.
class RobotStateMonitor {
 public:
  struct Params {
    double joint_state_timeout_s{0.5};  ///< since their arrival [s of wall time]
    bool robot_state{true};             ///< require robot/state and respect it
  };
  RobotStateMonitor(ros::NodeHandle handle, const Params& params);

  /// Latest position of every joint that was published. Error: kNoJointStates without a recent message.
  [[nodiscard]] tl::expected<arm::JointPositions, Status> positions() const;
  /// Present time on the robot's clock, estimated from the stamps of its joint states: the local clock
  /// (ros::Time) plus the largest difference of stamp and arrival within the last second, which belongs to
  /// the message with the smallest delay. Without stamped messages: the local clock. So a time sent to the
  /// robot is right although its clock may differ or a translator may shift its stamps.
  [[nodiscard]] ros::Time robot_time() const;
  /// Why the robot must not or cannot move; std::nullopt when it is ready.
  [[nodiscard]] std::optional<Status> not_ready_reason() const;

 private:
  void on_joints(const sensor_msgs::JointStateConstPtr& message);
  void note_clock(const ros::Time& stamp);
  void on_state(const baxter_core_msgs::AssemblyStateConstPtr& message);

  const Params params_;
  mutable std::mutex mutex_;
  arm::JointPositions positions_;
  ros::WallTime heard_;
  struct ClockSample {
    ros::WallTime heard;
    ros::Duration robot_ahead;  ///< stamp - arrival
  };
  std::deque<ClockSample> clock_samples_;  ///< of the last second, falling: only what may become the largest
  std::optional<baxter_core_msgs::AssemblyState> state_;
  ros::Subscriber joints_subscriber_;
  ros::Subscriber state_subscriber_;
};

}  // namespace extperfc::ros_arm
