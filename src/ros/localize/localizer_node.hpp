#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <diagnostic_updater/diagnostic_updater.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/SetMap.h>
#include <ros/node_handle.h>
#include <sensor_msgs/LaserScan.h>
#include <std_srvs/Empty.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_broadcaster.h>
#include <tf2_ros/transform_listener.h>

#include "ros/health/stream_health.hpp"
#include "ros/localize/localizer_engine.hpp"
#include "ros/localize/map_source.hpp"
#include "ros/params/localizer_params.hpp"

namespace extperfc::ros_localize {

/// Monte Carlo localization in a known map, with amcl's topics, services and parameters: a launch file for
/// amcl works after a change of package, type and name. Also a program: rosrun extperfc localizer.
///
/// Subscribes:
///   scan             sensor_msgs/LaserScan; several scanners may share the topic, upside down is recognised
///   initialpose      geometry_msgs/PoseWithCovarianceStamped in global_frame_id; an old one is moved by
///                    odometry
///   map              nav_msgs/OccupancyGrid, when use_map_topic is true and map_file empty
///   /tf, /tf_static  tf2_msgs/TFMessage
/// Publishes:
///   amcl_pose      geometry_msgs/PoseWithCovarianceStamped, latched, after every update, with the scan's
///                  stamp
///   particlecloud  geometry_msgs/PoseArray, latched, only while it has subscribers
///   /tf            tf2_msgs/TFMessage: global_frame_id -> odom_frame_id with every scan, dated
///                  transform_tolerance ahead of it
///   diagnostics    diagnostic_msgs/DiagnosticArray
/// Services:
///   global_localization      std_srvs/Empty: particles on the whole map
///   request_nomotion_update  std_srvs/Empty: update with the next scan, without motion
///   set_map                  nav_msgs/SetMap: another map and the pose in it; an invalid map or pose changes
///                            nothing
/// Calls:
///   static_map  nav_msgs/GetMap, until it answers, when use_map_topic is false and map_file empty
/// Parameters: amcl's, in config/localizer.yaml, and a given initial pose in config/initial_pose.yaml. The
///   node stores its pose in initial_pose_* and initial_cov_*, where the next start finds it. amcl's other
///   parameters are accepted without effect, and a warning names them. Without the YAML file min_particles is
///   500, laser_max_beams 60, update_min_a 0.2 rad, odom_model_type diff-corrected with alphas of 0.2, and
///   idle_update_period_s 1 s.
/// Frames: needs scan frame -> base_frame_id -> odom_frame_id at the scan's stamp.
/// Diagnostics: particles, pose, its standard deviations, weight of its cluster, fit, rates, latency, drops;
///   WARN without a map or scans, while lost, ambiguous (its cluster holds less than half of the weight) or
///   uncertain; ERROR while scans cannot be used.
/// Threads: callbacks store; one worker waits for transforms and computes. The newest scan replaces one that
///   waits.
class LocalizerNode {
 public:
  /// Errors: every bad parameter at once, a map_file that cannot be read.
  [[nodiscard]] static Result<std::unique_ptr<LocalizerNode>> make(const ros::NodeHandle& handle,
                                                                   const ros::NodeHandle& private_handle,
                                                                   const std::string& name);
  /// Stores the last pose, if save_pose_rate is positive.
  ~LocalizerNode();
  LocalizerNode(const LocalizerNode&) = delete;
  LocalizerNode& operator=(const LocalizerNode&) = delete;

 private:
  using ScanEvent = ros::MessageEvent<const sensor_msgs::LaserScan>;
  using PoseMessage = geometry_msgs::PoseWithCovarianceStamped;

  LocalizerNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                const ros_params::LocalizerNodeParams& params, const std::string& name);
  Result<void> start();
  void advertise();
  void on_scan(const ScanEvent& event);
  void on_initial_pose(const PoseMessage::ConstPtr& message);
  bool on_global_localization(std_srvs::Empty::Request&, std_srvs::Empty::Response&);
  bool on_nomotion_update(std_srvs::Empty::Request&, std_srvs::Empty::Response&);
  bool on_set_map(nav_msgs::SetMap::Request& request, nav_msgs::SetMap::Response& response);
  [[nodiscard]] Result<GivenPose> to_given_pose(const PoseMessage& message) const;
  [[nodiscard]] bool time_ran_back(const ros::Time& stamp);

  void work_off(const Work& work);
  void publish(const Located& located);
  void publish_pose(const Located& located);
  void publish_cloud(const ros::Time& stamp);
  void broadcast(const Located& located);
  void store_pose();
  void update_diagnostics();
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);
  void report_estimate(diagnostic_updater::DiagnosticStatusWrapper& status, const Located& located) const;

  ros::NodeHandle handle_;
  ros::NodeHandle private_handle_;
  const ros_params::LocalizerNodeParams params_;
  tf2_ros::Buffer tf_buffer_;
  tf2_ros::TransformListener tf_listener_{tf_buffer_};
  tf2_ros::TransformBroadcaster tf_broadcaster_;
  LocalizerInbox inbox_;
  LocalizerEngine engine_;  ///< of the worker
  MapSource map_source_;
  ros_health::InputHealth scan_health_{"scan"};
  ros_health::WorkHealth work_health_;

  ros::Publisher pose_publisher_;
  ros::Publisher cloud_publisher_;
  std::atomic<bool> cloud_wanted_{false};  ///< a subscriber connected
  ros::Time last_cloud_;                   ///< of the worker
  ros::Time last_now_;                     ///< of the scan callback
  ros::Time last_stamp_;                   ///< of the scan callback

  struct State {
    std::optional<Located> located;  ///< the latest
    std::size_t particles{0};
    std::uint64_t updates{0};
    std::uint64_t time_jumps{0};
    bool has_map{false};
    std::string map_error;
  };
  mutable std::mutex state_mutex_;
  State state_;

  diagnostic_updater::Updater updater_;
  ros::WallTime last_report_;
  ros::WallTimer diagnostics_timer_;
  ros::WallTimer store_timer_;
  ros::Subscriber scan_subscriber_;
  ros::Subscriber pose_subscriber_;
  ros::ServiceServer global_service_;
  ros::ServiceServer nomotion_service_;
  ros::ServiceServer map_service_;
  std::thread worker_;
};

}  // namespace extperfc::ros_localize
