#include "ros/navigate/pose_monitor.hpp"

#include <cmath>
#include <cstdio>
#include <utility>

#include <ros/console.h>

#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_navigate {

namespace {

using navigate::NavCode;
using navigate::NavError;

// Farther motion between two states means that odometry restarted or that localization found another place.
constexpr double kOdomJumpM = 0.5;
constexpr double kOdomJumpSpeedMS = 5.0;
constexpr double kMapJumpM = 0.5;
constexpr double kMapJumpRad = 0.5;

std::string shown(const char* format, double value) {
  char text[160];
  (void)std::snprintf(text, sizeof(text), format, value);
  return text;
}

double seconds(const ros::Time& from, const ros::Time& to) {
  return to.toSec() - from.toSec();
}

/// "lost: yes" of a localizer's diagnostics; its message then.
std::optional<std::string> lost_by(const diagnostic_msgs::DiagnosticStatus& status) {
  for (const auto& value : status.values)
    if (value.key == "lost" && value.value == "yes") return status.message;
  return std::nullopt;
}

/// "first/" for what is in the namespace /first, "" in the root. Diagnostics of several robots come on one
/// topic.
std::string own_names(const ros::NodeHandle& handle) {
  const std::string name = handle.resolveName("x");  // /first/x
  return name.substr(1, name.size() - 2);
}

}  // namespace

PoseMonitor::PoseMonitor(ros::NodeHandle handle, const ros_params::NavigatorNodeParams& params,
                         tf2_ros::Buffer& tf)
    : global_frame_(params.global_frame),
      odom_frame_(params.odom_frame),
      base_frame_(params.base_frame),
      tf_(tf),
      topic_(handle.resolveName("odom")),
      own_names_(own_names(handle)),
      limits_(params.limits) {
  health_.listening(true);
  odometry_subscriber_ = handle.subscribe("odom", 5, &PoseMonitor::on_odometry, this);
  pose_subscriber_ = handle.subscribe<geometry_msgs::PoseWithCovarianceStamped>(
      "amcl_pose", 2, [this](const auto& message) { on_pose(*message); });
  diagnostics_subscriber_ = handle.subscribe<diagnostic_msgs::DiagnosticArray>(
      "/diagnostics", 20, [this](const auto& message) { on_diagnostics(*message); });
}

PoseMonitor::~PoseMonitor() {
  odometry_subscriber_.shutdown();
  pose_subscriber_.shutdown();
  diagnostics_subscriber_.shutdown();
}

void PoseMonitor::set_limits(const ros_params::DataLimits& limits) {
  const std::lock_guard lock(mutex_);
  limits_ = limits;
}

void PoseMonitor::on_odometry(const ros::MessageEvent<const nav_msgs::Odometry>& event) {
  const auto& message = event.getConstMessage();
  health_.received(message->header.stamp, message.get(), ros_health::came_by_pointer(event));
  const auto& twist = message->twist.twist;
  if (!std::isfinite(twist.linear.x + twist.linear.y + twist.angular.z)) return;
  const std::lock_guard lock(mutex_);
  odometry_ = message;
}

void PoseMonitor::on_pose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  const auto covariance = ros_convert::to_covariance(message.pose.covariance);
  const double variance = std::max(covariance(0, 0), covariance(1, 1));
  if (!std::isfinite(variance)) return;
  const std::lock_guard lock(mutex_);
  position_sigma_m_ = std::sqrt(std::max(0.0, variance));
}

void PoseMonitor::on_diagnostics(const diagnostic_msgs::DiagnosticArray& message) {
  for (const auto& status : message.status) {
    const bool other_robot = status.name.compare(0, own_names_.size(), own_names_) != 0;
    if (other_robot || status.name.find("localizer") == std::string::npos) continue;
    const std::lock_guard lock(mutex_);
    lost_ = lost_by(status);
  }
}

void PoseMonitor::forget() {
  {
    const std::lock_guard lock(mutex_);
    odometry_.reset();
  }
  last_.reset();
}

RobotState PoseMonitor::state(const ros::Time& now) {
  RobotState state;
  state.stamp = now;
  state.fault = fault_of_odometry(now);
  if (!state.fault) state.fault = find_poses(state);
  if (state.fault) return state;
  find_jumps(state);
  const std::lock_guard lock(mutex_);
  if (lost_)
    state.fault = NavError{NavCode::kLocalizationLost, "the localizer is lost: " + *lost_};
  else if (position_sigma_m_ > limits_.position_sigma_m)
    state.fault = NavError{NavCode::kLocalizationLost,
                           shown("the pose is uncertain: standard deviation %.2f m", position_sigma_m_)};
  return state;
}

std::optional<NavError> PoseMonitor::fault_of_odometry(const ros::Time& now) const {
  const std::lock_guard lock(mutex_);
  if (!odometry_) return NavError{NavCode::kNoOdometry, "no odometry on " + topic_};
  const double age_s = seconds(odometry_->header.stamp, now);
  if (age_s <= limits_.odom_s && age_s >= -limits_.odom_s) return std::nullopt;
  return NavError{NavCode::kNoOdometry, "odometry on " + topic_ + shown(" is %.2f s old", age_s)};
}

std::optional<NavError> PoseMonitor::find_poses(RobotState& state) const {
  try {
    const auto odom_T_base = tf_.lookupTransform(odom_frame_, base_frame_, ros::Time(0));
    const auto map_T_odom = tf_.lookupTransform(global_frame_, odom_frame_, ros::Time(0));
    const auto odom_pose = ros_convert::to_pose2(odom_T_base.transform);
    const auto map_pose = ros_convert::to_pose2(map_T_odom.transform);
    if (!odom_pose || !map_pose) return NavError{NavCode::kNoTransform, "a transform is not finite"};
    const std::lock_guard lock(mutex_);
    if (const double age_s = seconds(odom_T_base.header.stamp, state.stamp); age_s > limits_.odom_s)
      return NavError{NavCode::kNoTransform,
                      "the transform " + odom_frame_ + " -> " + base_frame_ + shown(" is %.2f s old", age_s)};
    const double age_s = seconds(map_T_odom.header.stamp, state.stamp);
    if (age_s > limits_.transform_s && !map_T_odom.header.stamp.isZero())
      return NavError{NavCode::kNoTransform, "the transform " + global_frame_ + " -> " + odom_frame_ +
                                                 shown(" is %.2f s old", age_s)};
    state.odom_T_base = *odom_pose;
    state.map_T_base = compose(*map_pose, *odom_pose);
    const auto& twist = odometry_->twist.twist;
    state.velocity = {twist.linear.x, twist.linear.y, twist.angular.z};
    return std::nullopt;
  } catch (const tf2::TransformException& error) {
    return NavError{NavCode::kNoTransform, "no transform " + global_frame_ + " -> " + odom_frame_ + " -> " +
                                               base_frame_ + ": " + error.what()};
  }
}

void PoseMonitor::find_jumps(RobotState& state) {
  if (last_) {
    const double dt_s = std::abs(seconds(last_->stamp, state.stamp));
    const Pose2 step = between(last_->odom_T_base, state.odom_T_base);
    state.odom_jumped = std::hypot(step.x, step.y) > kOdomJumpM + kOdomJumpSpeedMS * dt_s;
    // How far the map moved under the robot.
    const Pose2 expected = compose(last_->map_T_base, step);
    const Pose2 off = between(expected, state.map_T_base);
    const bool map_jumped = std::hypot(off.x, off.y) > kMapJumpM || std::abs(off.yaw) > kMapJumpRad;
    state.jumped = state.odom_jumped || map_jumped;
  }
  last_ = state;
}

}  // namespace extperfc::ros_navigate
