#include "ros/navigate/goal_server.hpp"

#include <utility>
#include <vector>

#include <extperfc/NavCode.h>
#include <ros/console.h>

namespace extperfc::ros_navigate {

namespace {

using navigate::NavCode;
using navigate::NavEnd;

constexpr bool is(NavCode code, int constant) {
  return static_cast<int>(code) == constant;
}
static_assert(is(NavCode::kSuccess, extperfc::NavCode::SUCCESS));
static_assert(is(NavCode::kInvalidRequest, extperfc::NavCode::INVALID_REQUEST));
static_assert(is(NavCode::kCancelled, extperfc::NavCode::CANCELLED));
static_assert(is(NavCode::kReplaced, extperfc::NavCode::REPLACED));
static_assert(is(NavCode::kStartOutside, extperfc::NavCode::START_OUTSIDE));
static_assert(is(NavCode::kGoalOutside, extperfc::NavCode::GOAL_OUTSIDE));
static_assert(is(NavCode::kStartBlocked, extperfc::NavCode::START_BLOCKED));
static_assert(is(NavCode::kGoalBlocked, extperfc::NavCode::GOAL_BLOCKED));
static_assert(is(NavCode::kGoalUnknown, extperfc::NavCode::GOAL_UNKNOWN));
static_assert(is(NavCode::kNoPath, extperfc::NavCode::NO_PATH));
static_assert(is(NavCode::kPlanTimeout, extperfc::NavCode::PLAN_TIMEOUT));
static_assert(is(NavCode::kBlocked, extperfc::NavCode::BLOCKED));
static_assert(is(NavCode::kOscillating, extperfc::NavCode::OSCILLATING));
static_assert(is(NavCode::kCollisionAhead, extperfc::NavCode::COLLISION_AHEAD));
static_assert(is(NavCode::kNoOdometry, extperfc::NavCode::NO_ODOMETRY));
static_assert(is(NavCode::kNoTransform, extperfc::NavCode::NO_TRANSFORM));
static_assert(is(NavCode::kNoScan, extperfc::NavCode::NO_SCAN));
static_assert(is(NavCode::kNoMap, extperfc::NavCode::NO_MAP));
static_assert(is(NavCode::kLocalizationLost, extperfc::NavCode::LOCALIZATION_LOST));

std::string text_of(const NavEnd& end) {
  return std::string(to_string(end.error.code)) + ": " + end.error.message;
}

/// The action's status for an end: as move_base, preempted for what a client asked for.
template <typename Handle, typename Result>
void set_status(Handle& goal, const NavEnd& end, const Result& result) {
  switch (end.error.code) {
    case NavCode::kSuccess:
      return goal.setSucceeded(result, text_of(end));
    case NavCode::kCancelled:
    case NavCode::kReplaced:
      return goal.setCanceled(result, text_of(end));
    default:
      return goal.setAborted(result, text_of(end));
  }
}

}  // namespace

GoalServer::GoalServer(ros::NodeHandle handle, Callbacks callbacks)
    : callbacks_(std::move(callbacks)),
      move_base_(
          handle, "move_base", [this](const auto& goal) { on_move_base(goal); },
          [this](const auto& goal) { on_cancel(goal.getGoalID().id); }, false),
      follow_waypoints_(
          handle, "follow_waypoints", [this](const auto& goal) { on_waypoints(goal); },
          [this](const auto& goal) { on_cancel(goal.getGoalID().id); }, false),
      simple_publisher_(handle.advertise<move_base_msgs::MoveBaseActionGoal>("move_base/goal", 1)) {
  move_base_.start();
  follow_waypoints_.start();
  simple_subscriber_ = handle.subscribe<geometry_msgs::PoseStamped>(
      "move_base_simple/goal", 1, [this](const auto& message) { on_simple(*message); });
}

GoalServer::~GoalServer() {
  simple_subscriber_.shutdown();
  std::map<std::uint64_t, Client> clients;
  {
    const std::lock_guard lock(mutex_);
    clients.swap(clients_);
  }
  for (const auto& [task, client] : clients)
    client.finish({task, {NavCode::kCancelled, "the navigator ends"}, {}});
}

void GoalServer::on_simple(const geometry_msgs::PoseStamped& message) {
  move_base_msgs::MoveBaseActionGoal goal;
  goal.header.stamp = ros::Time::now();
  goal.goal.target_pose = message;
  simple_publisher_.publish(goal);
}

template <typename Handle>
void GoalServer::accept(Handle goal, const std::vector<geometry_msgs::PoseStamped>& poses,
                        bool stop_at_failure, Client client) {
  navigate::NavTask task;
  task.stop_at_failure = stop_at_failure;
  task.goals.reserve(poses.size());
  for (const auto& pose : poses) {
    const auto global = callbacks_.to_global(pose);
    if (!global) {
      ROS_ERROR("goal refused: %s", global.error().message.c_str());
      goal.setRejected({}, std::string(to_string(global.error().code)) + ": " + global.error().message);
      return;
    }
    task.goals.push_back(*global);
  }
  goal.setAccepted();
  {
    const std::lock_guard lock(mutex_);
    task.id = ++next_task_;
    clients_[task.id] = std::move(client);
  }
  callbacks_.start(task);
}

void GoalServer::on_move_base(const MoveBase::GoalHandle& goal) {
  Client client;
  client.finish = [goal = goal](const NavEnd& end) mutable {
    set_status(goal, end, move_base_msgs::MoveBaseResult());
  };
  client.feedback = [goal = goal](const geometry_msgs::PoseStamped& base, std::size_t, double) mutable {
    move_base_msgs::MoveBaseFeedback feedback;
    feedback.base_position = base;
    goal.publishFeedback(feedback);
  };
  client.is = [goal](const std::string& id) { return goal.getGoalID().id == id; };
  accept(goal, {goal.getGoal()->target_pose}, true, std::move(client));
}

void GoalServer::on_waypoints(const FollowWaypoints::GoalHandle& goal) {
  Client client;
  client.finish = [goal = goal](const NavEnd& end) mutable {
    extperfc::FollowWaypointsResult result;
    result.code = static_cast<std::int32_t>(end.error.code);
    result.message = end.error.message;
    result.missed.assign(end.missed.begin(), end.missed.end());
    set_status(goal, end, result);
  };
  client.feedback = [goal = goal](const geometry_msgs::PoseStamped& base, std::size_t waypoint,
                                  double distance_left_m) mutable {
    extperfc::FollowWaypointsFeedback feedback;
    feedback.waypoint = static_cast<std::uint32_t>(waypoint);
    feedback.base_position = base;
    feedback.distance_left = distance_left_m;
    goal.publishFeedback(feedback);
  };
  client.is = [goal](const std::string& id) { return goal.getGoalID().id == id; };
  accept(goal, goal.getGoal()->poses, goal.getGoal()->stop_at_failure != 0, std::move(client));
}

void GoalServer::on_cancel(const std::string& goal_id) {
  std::uint64_t task = 0;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, client] : clients_)
      if (client.is(goal_id)) task = id;
  }
  if (task != 0) callbacks_.cancel(task);
}

void GoalServer::finish(const NavEnd& end) {
  Client client;
  {
    const std::lock_guard lock(mutex_);
    const auto found = clients_.find(end.task);
    if (found == clients_.end()) return;
    client = std::move(found->second);
    clients_.erase(found);
  }
  client.finish(end);
}

void GoalServer::feedback(const geometry_msgs::PoseStamped& base, std::size_t waypoint,
                          double distance_left_m) {
  std::vector<Client> clients;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [task, client] : clients_) clients.push_back(client);
  }
  for (const auto& client : clients) client.feedback(base, waypoint, distance_left_m);
}

}  // namespace extperfc::ros_navigate
