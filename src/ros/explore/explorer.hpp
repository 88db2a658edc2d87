#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <actionlib/client/simple_action_client.h>
#include <actionlib/server/simple_action_server.h>
#include <extperfc/ExploreAction.h>
#include <move_base_msgs/MoveBaseAction.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/node_handle.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include "extperfc/navigate/exploration.hpp"

#include "ros/health/reporter.hpp"
#include "ros/params/explorer_params.hpp"

namespace extperfc::ros_explore {

/// Drives the robot to the borders of the known map until none is left that it can reach: the mapper maps a
/// floor without a driver.
///
/// Subscribes:
///   map  nav_msgs/OccupancyGrid, of the mapper
///   /tf, /tf_static  tf2_msgs/TFMessage
/// Publishes:
///   explore/frontiers  visualization_msgs/Marker, latched: cells of the frontiers, in the map's frame
///   diagnostics        diagnostic_msgs/DiagnosticArray
/// Actions:
///   explore  extperfc/Explore: begins at once; a new goal replaces the one under way
/// Calls:
///   move_base  move_base_msgs/MoveBase, the navigator's action: one goal after the other. A goal whose frontier
///              has become known meanwhile is replaced; one that fails, or takes longer than goal_timeout_s, is
///              tried once more at the end
///   move_base/make_plan  nav_msgs/GetPlan: whether the robot can get to a frontier; where no navigator offers
///              this, it tries
/// Parameters: config/explorer.yaml.
/// Frames: needs frame of the map -> robot_base_frame.
/// Diagnostics: frontiers left, goals reached and failed; WARN while no map has come.
/// Threads: callbacks store; the action server's thread chooses goals and waits.
class Explorer {
 public:
  Explorer(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
           const ros_params::ExplorerParams& params, const std::string& name);
  /// The goal under way is cancelled.
  ~Explorer();
  Explorer(const Explorer&) = delete;
  Explorer& operator=(const Explorer&) = delete;

 private:
  using Server = actionlib::SimpleActionServer<ExploreAction>;
  using Client = actionlib::SimpleActionClient<move_base_msgs::MoveBaseAction>;

  /// How driving to one goal ended.
  enum class Drive { kReached, kFailed, kOutdated, kStopped };

  /// Goals that failed one after the other with the robot at about the same place.
  struct Standstill {
    int failures{0};
    Pose2 pose;  ///< of the robot at the first
  };

  struct Map {
    nav_msgs::OccupancyGridConstPtr message;
    std::uint64_t number{0};  ///< of maps since the start
  };

  void on_map(const nav_msgs::OccupancyGridConstPtr& message);
  void execute(const ExploreGoalConstPtr& goal);
  void explore(const ExploreGoal& goal, ExploreResult& result);
  /// Bounds of a goal; empty after filling in the result.
  [[nodiscard]] std::optional<std::vector<Eigen::Vector2d>> bounds_of(const ExploreGoal& goal,
                                                                      ExploreResult& result);
  /// Whether this end of a drive is one of too many; fills in the result then.
  [[nodiscard]] bool is_stuck(Standstill& standstill, Drive ended, const navigate::Frontier& frontier,
                              ExploreResult& result);
  /// As choose(), which is asked once more with a newer map where the navigator has no plan to what is left.
  [[nodiscard]] std::optional<navigate::Frontier> choose_patiently(navigate::Exploration& exploration,
                                                                   ExploreResult& result);
  /// The next goal of the base; empty after filling in the result.
  [[nodiscard]] std::optional<navigate::Frontier> choose(navigate::Exploration& exploration,
                                                         ExploreResult& result);
  /// Whether the navigator has a plan.
  [[nodiscard]] bool can_reach(const std::string& map_frame, const Pose2& from, const Pose2& goal);
  [[nodiscard]] Drive drive(navigate::Exploration& exploration, const navigate::Frontier& frontier);
  void send(const navigate::Frontier& frontier, const navigate::Exploration& exploration);
  [[nodiscard]] Drive wait(const navigate::Exploration& exploration);
  [[nodiscard]] Result<Pose2> pose_in(const std::string& map_frame) const;
  /// True when the client cancelled, the time is over, or this ends.
  [[nodiscard]] bool stopped();
  [[nodiscard]] Map map() const;
  /// The newest map once it has a number above this; the newest after map_patience_s, or when stopped.
  void await_map_after(std::uint64_t number);
  void show(const std::vector<Eigen::Vector2d>& points_m, const nav_msgs::OccupancyGrid& map);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status) const;

  ros::NodeHandle handle_;
  const ros_params::ExplorerParams params_;
  tf2_ros::Buffer tf_buffer_;
  tf2_ros::TransformListener tf_listener_{tf_buffer_};
  ros::Publisher frontier_publisher_;

  mutable std::mutex mutex_;  ///< guards what follows
  std::condition_variable changed_;
  bool closing_{false};
  Map map_;
  std::optional<bool> drive_ended_;  ///< of the navigator's present goal: whether it was reached
  std::uint64_t drive_number_{0};    ///< ends of earlier goals do not count
  std::size_t frontiers_left_{0};
  std::size_t goals_reached_{0};
  std::size_t goals_failed_{0};
  bool exploring_{false};

  ros::Time deadline_;  ///< of the action's goal; zero: none
  Client move_base_;
  ros::ServiceClient make_plan_;
  bool has_plans_{false};  ///< the navigator answered when it was asked last
  ros::Subscriber map_subscriber_;
  std::unique_ptr<Server> server_;
  ros_health::Reporter reporter_;
};

}  // namespace extperfc::ros_explore
