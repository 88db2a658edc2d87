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

#include "ros/arm/ending.hpp"

namespace extperfc::arm_node {

/// Where the joints are and whether the robot may move: from robot/joint_states and robot/state.
/// Thread-safe.
class RobotWatch {
 public:
  struct Params {
    double joint_state_timeout_s{0.5};  ///< by the time they came in [s of wall time]
    bool robot_state{true};             ///< wait for robot/state and heed it
  };
  RobotWatch(ros::NodeHandle handle, const Params& params);

  /// Of all joints heard of, each by its latest message. Ending: kNoJointStates, when nothing came lately.
  [[nodiscard]] tl::expected<arm::JointPositions, Ending> positions() const;
  /// The robot's clock now, as the stamps of its joint states show it: our own clock (ros::Time) shifted by
  /// the largest difference of stamp and arrival of the last second, which is that of the message that was on
  /// its way for the shortest time. Our own clock while nothing with a stamp came. So a time given to the
  /// robot fits whether its clock agrees with ours, is off, or a translator shifts its stamps.
  [[nodiscard]] ros::Time robot_time() const;
  /// Why the robot must not or cannot move; nothing when it may.
  [[nodiscard]] std::optional<Ending> obstacle() const;

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

}  // namespace extperfc::arm_node
