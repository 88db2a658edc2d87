#include "ros/simulate/base_interface.hpp"

#include <cmath>
#include <utility>
#include <vector>

#include <nav_msgs/Odometry.h>
#include <ros/console.h>
#include <sensor_msgs/Imu.h>

#include "extperfc/base/math.hpp"
#include "extperfc/world/pose.hpp"

#include "ros/convert/geometry.hpp"
#include "ros/simulate/frames.hpp"

namespace extperfc::ros_simulate {

namespace {

constexpr double kSmall = 1e-6;  ///< variance of what does not move: planners divide by it

}  // namespace

BaseInterface::BaseInterface(ros::NodeHandle handle, SimHost& host,
                             const ros_params::BaseInterfaceParams& params, const simulate::BaseParams& noise)
    : host_(host),
      params_(params),
      noise_(noise),
      odom_ticker_(params.odom_rate_hz),
      imu_ticker_(params.imu_rate_hz),
      odom_publisher_(handle.advertise<nav_msgs::Odometry>("odom", 10)),
      imu_publisher_(handle.advertise<sensor_msgs::Imu>("imu/data", 20)) {
  host.after_step(
      [this](const simulate::Simulator& simulator, const ros::Time& stamp) { after_step(simulator, stamp); });
  command_subscriber_ = handle.subscribe("cmd_vel", 10, &BaseInterface::on_command, this);
}

void BaseInterface::on_command(const geometry_msgs::TwistConstPtr& message) {
  const Twist2 velocity{message->linear.x, message->linear.y, message->angular.z};
  if (!is_finite(velocity)) {
    if (refused_++ == 0) ROS_WARN("cmd_vel has numbers that are not finite: ignored");
    return;
  }
  if (host_.post([velocity](simulate::Simulator& simulator) { simulator.command_base(velocity); }))
    ++commands_;
}

void BaseInterface::after_step(const simulate::Simulator& simulator, const ros::Time& stamp) {
  const double time_s = simulator.time_s();
  if (time_s < last_time_s_) variance_ = {};  // the simulation was reset
  last_time_s_ = time_s;
  if (imu_ticker_.due(time_s) && imu_publisher_.getNumSubscribers() > 0) publish_imu(simulator.imu(), stamp);
  if (!odom_ticker_.due(time_s)) return;
  const auto base = simulator.base_state();
  blocked_ = base.blocked;
  grow_variance(base.measured);
  publish_frames(base, stamp);
  if (odom_publisher_.getNumSubscribers() > 0) publish_odometry(base, stamp);
}

/// Each metre and radian adds the wheels' errors squared, as if they were new ones every metre and radian.
void BaseInterface::grow_variance(const Twist2& measured) {
  const double period_s = 1.0 / odom_ticker_.rate_hz();
  const double forward_m = std::abs(measured.vx) * period_s;
  const double sideways_m = std::abs(measured.vy) * period_s;
  const double turned_rad = std::abs(measured.wz) * period_s;
  const double fraction2 = square(noise_.wheel_noise) + square(noise_.wheel_slip);
  const double driven2 = fraction2 * (forward_m + sideways_m);
  variance_.x_m2 += driven2;
  variance_.y_m2 += driven2 + square(noise_.lateral_slip) * sideways_m;
  variance_.yaw_rad2 += fraction2 * (turned_rad + forward_m + sideways_m);
}

void BaseInterface::publish_odometry(const simulate::BaseState& base, const ros::Time& stamp) {
  const auto message = boost::make_shared<nav_msgs::Odometry>();
  message->header.stamp = stamp;
  message->header.frame_id = kOdomFrame;
  message->child_frame_id = kFootprintFrame;
  message->pose.pose = ros_convert::to_message(to_pose(base.odometry));
  message->twist.twist = ros_convert::to_message(base.measured);
  const double fraction2 = square(noise_.wheel_noise) + square(noise_.wheel_slip);
  const Twist2& v = base.measured;
  message->pose.covariance =
      ros_convert::planar_covariance(variance_.x_m2, variance_.y_m2, variance_.yaw_rad2);
  message->twist.covariance = ros_convert::planar_covariance(
      kSmall + fraction2 * square(v.vx), kSmall + (fraction2 + square(noise_.lateral_slip)) * square(v.vy),
      kSmall + fraction2 * square(v.wz));
  odom_publisher_.publish(message);
}

void BaseInterface::publish_frames(const simulate::BaseState& base, const ros::Time& stamp) {
  std::vector<geometry_msgs::TransformStamped> transforms;
  const auto odom_T_base = to_pose(base.odometry);
  if (params_.publish_odom_frame)
    transforms.push_back(ros_convert::to_transform(odom_T_base, kOdomFrame, kFootprintFrame, stamp));
  if (params_.publish_map_frame)
    transforms.push_back(
        ros_convert::to_transform(to_pose(base.truth) * odom_T_base.inverse(), kMapFrame, kOdomFrame, stamp));
  if (!transforms.empty()) tf_broadcaster_.sendTransform(transforms);
}

void BaseInterface::publish_imu(const simulate::ImuSample& sample, const ros::Time& stamp) {
  const auto message = boost::make_shared<sensor_msgs::Imu>();
  message->header.stamp = stamp;
  message->header.frame_id = kImuFrame;
  message->orientation.z = std::sin(0.5 * sample.yaw);
  message->orientation.w = std::cos(0.5 * sample.yaw);
  const double drift2 = square(0.05);  // of the integrated yaw, which nothing corrects [rad^2]
  message->orientation_covariance = {kSmall, 0, 0, 0, kSmall, 0, 0, 0, drift2};
  message->angular_velocity = ros_convert::to_vector(sample.angular_velocity);
  message->linear_acceleration = ros_convert::to_vector(sample.acceleration);
  const double gyro2 = square(noise_.gyro_noise_rad_s) + square(noise_.gyro_bias_rad_s) + 1e-12;
  const double accel2 = square(noise_.accel_noise_m_s2) + 1e-12;
  message->angular_velocity_covariance = {gyro2, 0, 0, 0, gyro2, 0, 0, 0, gyro2};
  message->linear_acceleration_covariance = {accel2, 0, 0, 0, accel2, 0, 0, 0, accel2};
  imu_publisher_.publish(message);
}

void BaseInterface::report(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  status.summary(diagnostic_msgs::DiagnosticStatus::OK, blocked_ ? "blocked by an obstacle" : "free");
  status.add("cmd_vel received", commands_.load());
  status.add("cmd_vel refused", refused_.load());
}

}  // namespace extperfc::ros_simulate
