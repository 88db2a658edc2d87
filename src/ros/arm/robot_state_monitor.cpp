#include "ros/arm/robot_state_monitor.hpp"

#include <cmath>

namespace extperfc::ros_arm {

using arm::ArmCode;
using baxter_core_msgs::AssemblyState;

namespace {

constexpr double kClockWindow_s = 1.0;  // of the samples that the robot's clock is read from

}  // namespace

RobotStateMonitor::RobotStateMonitor(ros::NodeHandle handle, const Params& params) : params_(params) {
  joints_subscriber_ = handle.subscribe("robot/joint_states", 1, &RobotStateMonitor::on_joints, this,
                                        ros::TransportHints().tcpNoDelay());
  if (params_.robot_state)
    state_subscriber_ = handle.subscribe("robot/state", 1, &RobotStateMonitor::on_state, this);
}

void RobotStateMonitor::on_joints(const sensor_msgs::JointStateConstPtr& message) {
  const std::lock_guard lock(mutex_);
  const std::size_t count = std::min(message->name.size(), message->position.size());
  for (std::size_t i = 0; i < count; ++i)
    if (std::isfinite(message->position[i])) positions_[message->name[i]] = message->position[i];
  heard_ = ros::WallTime::now();
  if (!message->header.stamp.isZero()) note_clock(message->header.stamp);
}

void RobotStateMonitor::note_clock(const ros::Time& stamp) {
  const ros::Duration ahead = stamp - ros::Time::now();
  while (!clock_samples_.empty() && clock_samples_.back().robot_ahead <= ahead) clock_samples_.pop_back();
  clock_samples_.push_back({heard_, ahead});
  while ((heard_ - clock_samples_.front().heard).toSec() > kClockWindow_s) clock_samples_.pop_front();
}

ros::Time RobotStateMonitor::robot_time() const {
  const std::lock_guard lock(mutex_);
  const ros::Time now = ros::Time::now();
  return clock_samples_.empty() ? now : now + clock_samples_.front().robot_ahead;
}

void RobotStateMonitor::on_state(const baxter_core_msgs::AssemblyStateConstPtr& message) {
  const std::lock_guard lock(mutex_);
  state_ = *message;
}

tl::expected<arm::JointPositions, Status> RobotStateMonitor::positions() const {
  const std::lock_guard lock(mutex_);
  if (heard_.isZero())
    return failure(ArmCode::kNoJointStates,
                   "no message on robot/joint_states yet: is the robot switched on?");
  const double age = (ros::WallTime::now() - heard_).toSec();
  if (age > params_.joint_state_timeout_s)
    return failure(ArmCode::kNoJointStates,
                   "no message on robot/joint_states for " + std::to_string(age) + " s");
  return positions_;
}

std::optional<Status> RobotStateMonitor::not_ready_reason() const {
  if (!params_.robot_state) return std::nullopt;
  const std::lock_guard lock(mutex_);
  if (!state_)
    return Status{ArmCode::kRobotNotEnabled, "no message on robot/state yet: is the robot switched on?"};
  if (state_->stopped)
    return Status{ArmCode::kRobotStopped,
                  state_->estop_button == AssemblyState::ESTOP_BUTTON_PRESSED
                      ? "the emergency stop is pressed: release it, reset and enable the robot"
                      : "the robot is stopped: reset it (robot/set_super_reset) and enable it"};
  if (state_->error) return Status{ArmCode::kRobotStopped, "the robot reports an error: see robot/state"};
  if (!state_->enabled)
    return Status{ArmCode::kRobotNotEnabled,
                  "the robot is not enabled: publish true on robot/set_super_enable"};
  return std::nullopt;
}

}  // namespace extperfc::ros_arm
