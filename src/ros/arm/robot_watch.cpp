#include "ros/arm/robot_watch.hpp"

#include <cmath>

namespace extperfc::arm_node {

using arm::ArmCode;
using baxter_core_msgs::AssemblyState;

namespace {

constexpr double kClockWindow_s = 1.0;  // of the samples that the robot's clock is read from

}  // namespace

RobotWatch::RobotWatch(ros::NodeHandle handle, const Params& params) : params_(params) {
  joints_subscriber_ = handle.subscribe("robot/joint_states", 1, &RobotWatch::on_joints, this,
                                        ros::TransportHints().tcpNoDelay());
  if (params_.robot_state)
    state_subscriber_ = handle.subscribe("robot/state", 1, &RobotWatch::on_state, this);
}

void RobotWatch::on_joints(const sensor_msgs::JointStateConstPtr& message) {
  const std::lock_guard lock(mutex_);
  const std::size_t count = std::min(message->name.size(), message->position.size());
  for (std::size_t i = 0; i < count; ++i)
    if (std::isfinite(message->position[i])) positions_[message->name[i]] = message->position[i];
  heard_ = ros::WallTime::now();
  if (!message->header.stamp.isZero()) note_clock(message->header.stamp);
}

void RobotWatch::note_clock(const ros::Time& stamp) {
  const ros::Duration ahead = stamp - ros::Time::now();
  while (!clock_samples_.empty() && clock_samples_.back().robot_ahead <= ahead) clock_samples_.pop_back();
  clock_samples_.push_back({heard_, ahead});
  while ((heard_ - clock_samples_.front().heard).toSec() > kClockWindow_s) clock_samples_.pop_front();
}

ros::Time RobotWatch::robot_time() const {
  const std::lock_guard lock(mutex_);
  const ros::Time now = ros::Time::now();
  return clock_samples_.empty() ? now : now + clock_samples_.front().robot_ahead;
}

void RobotWatch::on_state(const baxter_core_msgs::AssemblyStateConstPtr& message) {
  const std::lock_guard lock(mutex_);
  state_ = *message;
}

tl::expected<arm::JointPositions, Ending> RobotWatch::positions() const {
  const std::lock_guard lock(mutex_);
  if (heard_.isZero())
    return end(ArmCode::kNoJointStates, "nothing came on robot/joint_states yet: is the robot on?");
  const double age = (ros::WallTime::now() - heard_).toSec();
  if (age > params_.joint_state_timeout_s)
    return end(ArmCode::kNoJointStates,
               "robot/joint_states has been silent for " + std::to_string(age) + " s");
  return positions_;
}

std::optional<Ending> RobotWatch::obstacle() const {
  if (!params_.robot_state) return std::nullopt;
  const std::lock_guard lock(mutex_);
  if (!state_) return Ending{ArmCode::kRobotNotEnabled, "nothing came on robot/state yet: is the robot on?"};
  if (state_->stopped)
    return Ending{ArmCode::kRobotStopped,
                  state_->estop_button == AssemblyState::ESTOP_BUTTON_PRESSED
                      ? "the emergency stop is pressed: release it, reset and enable the robot"
                      : "the robot is stopped: reset it (robot/set_super_reset) and enable it"};
  if (state_->error) return Ending{ArmCode::kRobotStopped, "the robot reports an error: see robot/state"};
  if (!state_->enabled)
    return Ending{ArmCode::kRobotNotEnabled,
                  "the robot is not enabled: publish true on robot/set_super_enable"};
  return std::nullopt;
}

}  // namespace extperfc::arm_node
