#pragma once

#include <atomic>
#include <cstdint>

#include <diagnostic_updater/DiagnosticStatusWrapper.h>
#include <geometry_msgs/Twist.h>
#include <ros/node_handle.h>
#include <tf2_ros/transform_broadcaster.h>

#include "extperfc/simulate/simulator.hpp"

#include "ros/params/simulator_params.hpp"
#include "ros/simulate/sim_host.hpp"
#include "ros/simulate/ticker.hpp"

namespace extperfc::ros_simulate {

/// How wrong the odometry may be by now: a random walk over what was driven.
struct OdometryVariance {
  double x_m2{1e-6};
  double y_m2{1e-6};
  double yaw_rad2{1e-6};
};

/// The mobile base as its driver shows it.
///
/// Subscribes:
///   cmd_vel  geometry_msgs/Twist: linear.x, linear.y, angular.z
/// Publishes:
///   odom      nav_msgs/Odometry, odom -> base_footprint, with covariance
///   imu/data  sensor_msgs/Imu in imu_link
///   /tf       tf2_msgs/TFMessage: odom -> base_footprint and, when wanted, map -> odom
class BaseInterface {
 public:
  BaseInterface(ros::NodeHandle handle, SimHost& host, const ros_params::BaseInterfaceParams& params,
                const simulate::BaseParams& noise);
  /// Commands end before the host does.
  void shutdown() { command_subscriber_.shutdown(); }

  void report(diagnostic_updater::DiagnosticStatusWrapper& status) const;

 private:
  void on_command(const geometry_msgs::TwistConstPtr& message);
  void after_step(const simulate::Simulator& simulator, const ros::Time& stamp);
  void publish_odometry(const simulate::BaseState& base, const ros::Time& stamp);
  void publish_frames(const simulate::BaseState& base, const ros::Time& stamp);
  void publish_imu(const simulate::ImuSample& sample, const ros::Time& stamp);
  void grow_variance(const Twist2& measured);

  SimHost& host_;
  const ros_params::BaseInterfaceParams params_;
  const simulate::BaseParams noise_;
  Ticker odom_ticker_;
  Ticker imu_ticker_;
  OdometryVariance variance_;
  double last_time_s_{0};
  std::atomic<std::uint64_t> commands_{0};
  std::atomic<std::uint64_t> refused_{0};
  std::atomic<bool> blocked_{false};
  ros::Publisher odom_publisher_;
  ros::Publisher imu_publisher_;
  tf2_ros::TransformBroadcaster tf_broadcaster_;
  ros::Subscriber command_subscriber_;
};

}  // namespace extperfc::ros_simulate
