#pragma once

#include <mutex>
#include <optional>
#include <string>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>
#include <tf2_ros/buffer.h>

#include "extperfc/navigate/nav_error.hpp"
#include "extperfc/world/pose.hpp"

#include "ros/health/stream_health.hpp"
#include "ros/params/navigator_params.hpp"

namespace extperfc::ros_navigate {

/// Where the robot is, or why that is not known.
struct RobotState {
  ros::Time stamp;
  std::optional<navigate::NavError> fault;
  Pose2 map_T_base;
  Pose2 odom_T_base;
  Twist2 velocity;     ///< in the base's frame
  bool jumped{false};  ///< the pose in odom or in the map, since the last state()
  bool odom_jumped{false};
};

/// Pose and velocity of the base from tf and the topics odom, amcl_pose and diagnostics: their age, jumps,
/// and whether the localizer is lost. Callbacks store; state() is called by one thread.
class PoseMonitor {
 public:
  PoseMonitor(ros::NodeHandle handle, const ros_params::NavigatorNodeParams& params, tf2_ros::Buffer& tf);
  ~PoseMonitor();
  PoseMonitor(const PoseMonitor&) = delete;
  PoseMonitor& operator=(const PoseMonitor&) = delete;

  [[nodiscard]] RobotState state(const ros::Time& now);
  /// Time ran back: what is known is of another time.
  void forget();
  void set_limits(const ros_params::DataLimits& limits);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status, double timeout_s) {
    health_.report(status, topic_, timeout_s);
  }

 private:
  void on_odometry(const ros::MessageEvent<const nav_msgs::Odometry>& event);
  void on_pose(const geometry_msgs::PoseWithCovarianceStamped& message);
  void on_diagnostics(const diagnostic_msgs::DiagnosticArray& message);
  [[nodiscard]] std::optional<navigate::NavError> fault_of_odometry(const ros::Time& now) const;
  [[nodiscard]] std::optional<navigate::NavError> find_poses(RobotState& state) const;
  void find_jumps(RobotState& state);

  const std::string global_frame_;
  const std::string odom_frame_;
  const std::string base_frame_;
  tf2_ros::Buffer& tf_;
  std::string topic_;
  const std::string own_names_;  ///< what names in diagnostics of this robot begin with
  ros_health::InputHealth health_{"odometry"};

  mutable std::mutex mutex_;
  ros_params::DataLimits limits_;
  nav_msgs::Odometry::ConstPtr odometry_;
  double position_sigma_m_{0};
  std::optional<std::string> lost_;  ///< message of the localizer

  std::optional<RobotState> last_;  ///< of state()'s thread
  ros::Subscriber odometry_subscriber_;
  ros::Subscriber pose_subscriber_;
  ros::Subscriber diagnostics_subscriber_;
};

}  // namespace extperfc::ros_navigate
