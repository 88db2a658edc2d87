#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include <actionlib/server/action_server.h>
#include <extperfc/FollowWaypointsAction.h>
#include <geometry_msgs/PoseStamped.h>
#include <move_base_msgs/MoveBaseAction.h>
#include <ros/node_handle.h>

#include "extperfc/navigate/navigator.hpp"

namespace extperfc::ros_navigate {

/// Goals of clients: the actions move_base and follow_waypoints, and the topic move_base_simple/goal. The
/// newest goal replaces the one under way. Callbacks and the control thread may call at once; no lock is held
/// while the navigator is called.
class GoalServer {
 public:
  struct Callbacks {
    /// The pose in the global frame; an error for frames that are not known.
    std::function<navigate::NavResult<Pose2>(const geometry_msgs::PoseStamped&)> to_global;
    std::function<void(const navigate::NavTask&)> start;  ///< calls finish() for the replaced task
    std::function<void(std::uint64_t task)> cancel;       ///< calls finish()
  };

  GoalServer(ros::NodeHandle handle, Callbacks callbacks);
  /// Every goal is aborted.
  ~GoalServer();
  GoalServer(const GoalServer&) = delete;
  GoalServer& operator=(const GoalServer&) = delete;

  void finish(const navigate::NavEnd& end);
  void feedback(const geometry_msgs::PoseStamped& base, std::size_t waypoint, double distance_left_m);

 private:
  using MoveBase = actionlib::ActionServer<move_base_msgs::MoveBaseAction>;
  using FollowWaypoints = actionlib::ActionServer<extperfc::FollowWaypointsAction>;

  /// What a client waits for.
  struct Client {
    std::function<void(const navigate::NavEnd&)> finish;
    std::function<void(const geometry_msgs::PoseStamped&, std::size_t, double)> feedback;
    std::function<bool(const std::string& goal_id)> is;
  };

  void on_move_base(const MoveBase::GoalHandle& goal);
  void on_waypoints(const FollowWaypoints::GoalHandle& goal);
  void on_simple(const geometry_msgs::PoseStamped& message);
  void on_cancel(const std::string& goal_id);
  template <typename Handle>
  void accept(Handle goal, const std::vector<geometry_msgs::PoseStamped>& poses, bool stop_at_failure,
              Client client);

  Callbacks callbacks_;
  std::mutex mutex_;
  std::map<std::uint64_t, Client> clients_;  ///< by task
  std::uint64_t next_task_{0};
  MoveBase move_base_;
  FollowWaypoints follow_waypoints_;
  ros::Publisher simple_publisher_;
  ros::Subscriber simple_subscriber_;
};

}  // namespace extperfc::ros_navigate
