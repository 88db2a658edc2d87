#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <extperfc/NavigationStatus.h>
#include <geometry_msgs/Twist.h>
#include <nav_msgs/GetPlan.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <std_srvs/Empty.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include "extperfc/navigate/navigator.hpp"

#include "ros/health/reporter.hpp"
#include "ros/health/stream_health.hpp"
#include "ros/navigate/cost_maps.hpp"
#include "ros/navigate/display.hpp"
#include "ros/navigate/goal_server.hpp"
#include "ros/navigate/guard_thread.hpp"
#include "ros/navigate/outline_monitor.hpp"
#include "ros/navigate/people_tracker.hpp"
#include "ros/navigate/plan_worker.hpp"
#include "ros/navigate/planner_plugins.hpp"
#include "ros/navigate/pose_monitor.hpp"
#include "ros/params/navigator_params.hpp"
#include "ros/params/reconfigure.hpp"

namespace extperfc::ros_navigate {

/// Drives the base to goals, with move_base's actions, topics, services and parameters. Also a program:
/// rosrun extperfc navigator.
///
/// Subscribes:
///   move_base_simple/goal  geometry_msgs/PoseStamped: rviz's 2D Nav Goal
///   odom             nav_msgs/Odometry: the velocity of the base
///   scan_nearest     sensor_msgs/LaserScan: obstacles
///   scan             sensor_msgs/LaserScan: the same, where scan_nearest has no publisher
///   obstacle_points  sensor_msgs/PointCloud2: more obstacles, by their heights
///   map              nav_msgs/OccupancyGrid
///   map_updates      map_msgs/OccupancyGridUpdate
///   joint_states     sensor_msgs/JointState: arms that stick out belong to the footprint
///   amcl_pose        geometry_msgs/PoseWithCovarianceStamped: how certain the pose is
///   /diagnostics     diagnostic_msgs/DiagnosticArray: whether the localizer is lost
///   /tf, /tf_static  tf2_msgs/TFMessage
/// Publishes:
///   cmd_vel                             geometry_msgs/Twist, only while a goal is active, and zero at its end
///   navigation_status                   extperfc/NavigationStatus, latched
///   move_base/current_goal              geometry_msgs/PoseStamped, latched
///   move_base/global_plan               nav_msgs/Path, latched
///   move_base/local_plan                nav_msgs/Path
///   move_base/candidates                visualization_msgs/MarkerArray: trajectories of the local planner
///   move_base/people                    visualization_msgs/MarkerArray: who walks
///   move_base/people_tracks             extperfc/TrackArray, one for each scan: what the map does not explain and
///                                       has a person's size, walking or standing, in odom_frame; score 1 for
///                                       who has walked a metre and not stood for people_stand_s, else 0
///   move_base/global_costmap/costmap    nav_msgs/OccupancyGrid, latched, and ..._updates
///   move_base/local_costmap/costmap     nav_msgs/OccupancyGrid, latched, and ..._updates
///   move_base/local_costmap/footprint   geometry_msgs/PolygonStamped
///   diagnostics                         diagnostic_msgs/DiagnosticArray
/// Actions:
///   move_base         move_base_msgs/MoveBaseAction; the status text begins with the code's name
///   follow_waypoints  extperfc/FollowWaypointsAction
/// Services:
///   move_base/make_plan       nav_msgs/GetPlan: also while a goal is active; an empty path without a plan
///   move_base/clear_costmaps  std_srvs/Empty: forgets what sensors saw
///   ~set_parameters           dynamic_reconfigure/Reconfigure
/// Parameters: config/navigator.yaml. move_base's other parameters are accepted without effect, and a warning
///   names them.
/// Frames: needs global_frame -> odom_frame -> robot_base_frame, and the frames of the sensors.
/// Diagnostics: state, code and reason of the last goal, cycle and planning times, rates, footprint; WARN
///   while a goal waits for data, and without a map or scans.
/// Threads: callbacks (three), the cost maps, the global planner, the control cycle, and the collision guard,
///   which has the last word on cmd_vel and sends zero when the control cycle falls silent.
class NavigatorNode {
 public:
  /// Errors: every bad parameter at once, planners that cannot be loaded, a zones file that cannot be read.
  [[nodiscard]] static Result<std::unique_ptr<NavigatorNode>> make(const ros::NodeHandle& handle,
                                                                   const ros::NodeHandle& private_handle,
                                                                   const std::string& name);
  /// Stops the base if a goal is active.
  ~NavigatorNode();
  NavigatorNode(const NavigatorNode&) = delete;
  NavigatorNode& operator=(const NavigatorNode&) = delete;

 private:
  NavigatorNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                ros_params::NavigatorNodeParams params, const std::string& name);
  [[nodiscard]] Result<void> start();
  void advertise();
  [[nodiscard]] Result<void> apply_params();

  void control_loop();
  [[nodiscard]] bool wait_until(const ros::Time& due);
  void time_ran_back();
  void cycle(const ros::Time& now);
  [[nodiscard]] navigate::NavigatorInput gather(const ros::Time& now, const RobotState& state,
                                                const CostMaps::GridPtr& costs,
                                                const OutlineMonitor::FootprintPtr& footprint);
  void send(const navigate::NavigatorOutput& output, const RobotState& state);
  void act(navigate::NavigatorOutput& output, const ros::Time& now);
  void show(const navigate::NavigatorOutput& output, const RobotState& state, const ros::Time& now);
  void finish(const navigate::NavEnd& end);
  void publish_status(const RobotState& state, const ros::Time& now);
  void on_scan(const PlacedScan& placed);

  [[nodiscard]] navigate::NavResult<Pose2> to_global(const geometry_msgs::PoseStamped& pose);
  void start_task(const navigate::NavTask& task);
  void cancel_task(std::uint64_t task);
  bool on_make_plan(nav_msgs::GetPlan::Request& request, nav_msgs::GetPlan::Response& response);
  bool on_clear(std_srvs::Empty::Request&, std_srvs::Empty::Response&);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::CallbackQueue queue_;
  ros::NodeHandle handle_;
  ros::NodeHandle private_handle_;
  ros::NodeHandle server_handle_;  ///< move_base's namespace
  ros_params::NavigatorNodeParams params_;
  PlannerPlugins plugins_;
  tf2_ros::Buffer tf_buffer_;
  std::unique_ptr<tf2_ros::TransformListener> tf_listener_;
  PoseMonitor poses_;
  OutlineMonitor outline_;
  PeopleTracker people_;
  ros::Publisher tracks_publisher_;
  std::unique_ptr<GuardThread> guard_;
  CostMaps costs_;
  std::unique_ptr<PlanWorker> planning_;

  std::mutex mutex_;  ///< guards what follows
  std::unique_ptr<navigate::Navigator> navigator_;
  std::optional<std::uint64_t> active_task_;
  navigate::NavError last_end_{navigate::NavCode::kSuccess, ""};

  // Of the control thread.
  Display display_;
  CostMapPublisher global_publisher_;
  CostMapPublisher local_publisher_;
  OutlineMonitor::FootprintPtr footprint_;
  ros::Time last_now_;
  ros::Time shown_;
  ros::Time maps_shown_;
  ros::Time settled_;  ///< odometry jumped: not before
  bool sending_{false};
  ros::Publisher velocity_publisher_;
  ros::Publisher status_publisher_;

  std::atomic<double> controller_period_s_{0.05};
  std::atomic<bool> stopping_{false};
  ros_health::WorkHealth cycle_health_;
  std::unique_ptr<GoalServer> goals_;
  std::unique_ptr<ros_params::Reconfigure> reconfigure_;
  ros::ServiceServer plan_service_;
  ros::ServiceServer clear_service_;
  std::unique_ptr<ros_health::Reporter> reporter_;
  ros::AsyncSpinner spinner_{3, &queue_};
  std::thread control_thread_;
};

}  // namespace extperfc::ros_navigate
