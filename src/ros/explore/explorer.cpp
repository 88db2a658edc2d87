#include "ros/explore/explorer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <nav_msgs/GetPlan.h>
#include <tf2_eigen/tf2_eigen.h>
#include <visualization_msgs/Marker.h>

#include "extperfc/navigate/static_layer.hpp"

#include "ros/convert/occupancy_grid.hpp"
#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_explore {

namespace {

constexpr bool kLatched = true;
constexpr auto kLook = std::chrono::milliseconds(100);  // between checks for the client's cancellation
constexpr std::size_t kMaxBounds = 200;

float free_area_m2(const nav_msgs::OccupancyGrid& map) {
  constexpr std::int8_t kMaxFree = 20;  // [percent]
  const auto cells = std::count_if(map.data.begin(), map.data.end(),
                                   [](std::int8_t cell) { return cell >= 0 && cell <= kMaxFree; });
  return static_cast<float>(cells) * map.info.resolution * map.info.resolution;
}

void end(ExploreResult& result, std::uint8_t code, const std::string& message) {
  result.code = code;
  result.message = message;
}

std::string finished_message(std::size_t unreachable) {
  std::string message = "no frontier is left that the robot can reach";
  if (unreachable > 0) message += "; the navigator has no plan to " + std::to_string(unreachable);
  return message;
}

Result<navigate::CostGrid> to_costs(const nav_msgs::OccupancyGrid& message) {
  const auto map = ros_convert::to_occupancy_grid(message);
  if (!map) return tl::unexpected(map.error());
  try {
    return navigate::costs_of(*map);
  } catch (const std::invalid_argument& error) {  // too large
    return fail(ErrorCode::kUnsupported, std::string("the map cannot be explored: ") + error.what());
  }
}

}  // namespace

Explorer::Explorer(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                   const ros_params::ExplorerParams& params, const std::string& name)
    : handle_(handle),
      params_(params),
      move_base_(handle_, "move_base", false),
      make_plan_(handle_.serviceClient<nav_msgs::GetPlan>("move_base/make_plan")),
      reporter_(handle, private_handle, name) {
  frontier_publisher_ = handle_.advertise<visualization_msgs::Marker>("explore/frontiers", 1, kLatched);
  server_ = std::make_unique<Server>(
      handle_, "explore", [this](const ExploreGoalConstPtr& goal) { execute(goal); }, false);
  map_subscriber_ = handle_.subscribe("map", 1, &Explorer::on_map, this);
  server_->start();
  reporter_.add("explorer", [this](auto& status) { report(status); });
  reporter_.start();
}

Explorer::~Explorer() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  map_subscriber_.shutdown();
  server_.reset();  // waits for its thread
}

void Explorer::on_map(const nav_msgs::OccupancyGridConstPtr& message) {
  {
    const std::lock_guard lock(mutex_);
    map_.message = message;
    ++map_.number;
  }
  changed_.notify_all();
}

void Explorer::execute(const ExploreGoalConstPtr& goal) {
  ExploreResult result;
  deadline_ = goal->time_limit > 0 ? ros::Time::now() + ros::Duration(goal->time_limit) : ros::Time();
  {
    const std::lock_guard lock(mutex_);
    exploring_ = true;
  }
  explore(*goal, result);
  if (const auto map = this->map().message) result.known_area = free_area_m2(*map);
  {
    const std::lock_guard lock(mutex_);
    exploring_ = false;
  }
  if (result.code == ExploreResult::FINISHED)
    server_->setSucceeded(result, result.message);
  else if (result.code == ExploreResult::CANCELLED)
    server_->setPreempted(result, result.message);
  else
    server_->setAborted(result, result.message);
}

void Explorer::explore(const ExploreGoal& goal, ExploreResult& result) {
  await_map_after(0);
  const auto bounds_m = bounds_of(goal, result);
  if (!bounds_m) return;
  if (!move_base_.waitForServer(ros::Duration(params_.navigator_patience_s))) {
    end(result, ExploreResult::NO_NAVIGATOR, "no action server move_base: start the navigator");
    return;
  }
  navigate::Exploration exploration(params_.footprint.padded(), params_.frontiers, *bounds_m);
  Drive ended = Drive::kReached;
  Standstill standstill;
  while (const auto frontier = choose_patiently(exploration, result)) {
    ended = drive(exploration, *frontier);
    if (ended == Drive::kFailed) exploration.failed();
    if (ended == Drive::kReached) {
      await_map_after(map().number);
      exploration.reached();
    }
    {
      const std::lock_guard lock(mutex_);
      goals_reached_ = exploration.goals_reached();
      goals_failed_ = exploration.goals_failed();
    }
    if (is_stuck(standstill, ended, *frontier, result)) break;
  }
  if (ended == Drive::kOutdated) move_base_.cancelGoal();
  result.goals_reached = static_cast<std::uint32_t>(exploration.goals_reached());
  result.goals_failed = static_cast<std::uint32_t>(exploration.goals_failed());
}

std::optional<std::vector<Eigen::Vector2d>> Explorer::bounds_of(const ExploreGoal& goal,
                                                                ExploreResult& result) {
  const auto map = this->map().message;
  if (!map) {
    end(result, ExploreResult::NO_MAP, "no map came: start the mapper");
    return std::nullopt;
  }
  std::vector<Eigen::Vector2d> bounds_m;
  const auto& points = goal.bounds.polygon.points;
  if (points.empty()) return bounds_m;
  const auto& frame = goal.bounds.header.frame_id;
  if (!frame.empty() &&
      ros_convert::without_slash(frame) != ros_convert::without_slash(map->header.frame_id)) {
    end(result, ExploreResult::INVALID,
        "the bounds are in the frame " + frame + ": give them in " + map->header.frame_id);
    return std::nullopt;
  }
  bounds_m.reserve(points.size());
  for (const auto& point : points) bounds_m.emplace_back(point.x, point.y);
  const bool finite =
      std::all_of(bounds_m.begin(), bounds_m.end(), [](const auto& p) { return p.allFinite(); });
  if (points.size() >= 3 && points.size() <= kMaxBounds && finite) return bounds_m;
  end(result, ExploreResult::INVALID, "the bounds must have 3 to 200 finite points");
  return std::nullopt;
}

/// Without plans a goal may fail because no path leads there.
bool Explorer::is_stuck(Standstill& standstill, Drive ended, const navigate::Frontier& frontier,
                        ExploreResult& result) {
  constexpr int kFailures = 3;
  constexpr double kMovedM = 0.3;
  if (ended != Drive::kFailed || !has_plans_) {
    standstill = {};
    return false;
  }
  const auto pose = pose_in(map().message->header.frame_id);
  if (!pose) return false;
  if (standstill.failures == 0 ||
      std::hypot(pose->x - standstill.pose.x, pose->y - standstill.pose.y) > kMovedM)
    standstill = {0, *pose};
  if (++standstill.failures < kFailures) return false;
  std::ostringstream message;
  message << std::fixed << std::setprecision(2) << "the robot does not get away from (" << pose->x << ", "
          << pose->y << "): " << kFailures << " goals failed, the last at (" << frontier.goal.x << ", "
          << frontier.goal.y << "); move it, or see what the navigator says";
  end(result, ExploreResult::STUCK, message.str());
  return true;
}

/// Who stands in a door may go, and obstacles that went are forgotten.
std::optional<navigate::Frontier> Explorer::choose_patiently(navigate::Exploration& exploration,
                                                             ExploreResult& result) {
  auto frontier = choose(exploration, result);
  if (!frontier && result.code == ExploreResult::FINISHED && exploration.unreachable() > 0) {
    await_map_after(map().number);
    frontier = choose(exploration, result);
  }
  return frontier;
}

std::optional<navigate::Frontier> Explorer::choose(navigate::Exploration& exploration,
                                                   ExploreResult& result) {
  if (server_->isPreemptRequested() || !server_->isActive()) {
    end(result, ExploreResult::CANCELLED, "cancelled");
    return std::nullopt;
  }
  if (stopped()) {
    end(result, ExploreResult::TIME_LIMIT, "the time is over, or the explorer ends");
    return std::nullopt;
  }
  const auto message = map().message;
  const auto costs = to_costs(*message);
  if (!costs) {
    end(result, ExploreResult::NO_MAP, costs.error().message);
    return std::nullopt;
  }
  const auto pose = pose_in(message->header.frame_id);
  if (!pose) {
    end(result, ExploreResult::NO_POSE, pose.error().message);
    return std::nullopt;
  }
  auto next = exploration.next(*costs, *pose, [&](const Pose2& goal) {
    return stopped() || can_reach(message->header.frame_id, *pose, goal);
  });
  {
    const std::lock_guard lock(mutex_);
    frontiers_left_ = exploration.frontiers_left();
  }
  if (!next) {
    end(result, ExploreResult::NO_POSE, next.error().message);
    return std::nullopt;
  }
  show(*next ? (*next)->points_m : std::vector<Eigen::Vector2d>{}, *message);
  if (!*next) end(result, ExploreResult::FINISHED, finished_message(exploration.unreachable()));
  return *next;
}

/// True as well where no one makes plans: then driving shows it.
bool Explorer::can_reach(const std::string& map_frame, const Pose2& from, const Pose2& goal) {
  nav_msgs::GetPlan plan;
  plan.request.start.header.frame_id = plan.request.goal.header.frame_id = map_frame;
  plan.request.start.pose = ros_convert::to_pose_message(from);
  plan.request.goal.pose = ros_convert::to_pose_message(goal);
  has_plans_ = make_plan_.call(plan);
  return !has_plans_ || !plan.response.plan.poses.empty();
}

Explorer::Drive Explorer::drive(navigate::Exploration& exploration, const navigate::Frontier& frontier) {
  send(frontier, exploration);
  const Drive ended = wait(exploration);
  // The next goal replaces an outdated one without a stop.
  if (ended == Drive::kFailed || ended == Drive::kStopped) move_base_.cancelGoal();
  return ended;
}

void Explorer::send(const navigate::Frontier& frontier, const navigate::Exploration& exploration) {
  const auto message = map().message;
  move_base_msgs::MoveBaseGoal goal;
  goal.target_pose.header.frame_id = message->header.frame_id;
  goal.target_pose.header.stamp = ros::Time::now();
  goal.target_pose.pose = ros_convert::to_pose_message(frontier.goal);
  ExploreFeedback feedback;
  feedback.frontiers = static_cast<std::uint32_t>(exploration.frontiers_left());
  feedback.failed_frontiers = static_cast<std::uint32_t>(exploration.blacklisted());
  feedback.goal = goal.target_pose;
  feedback.known_area = free_area_m2(*message);
  server_->publishFeedback(feedback);
  std::uint64_t number = 0;
  {
    const std::lock_guard lock(mutex_);
    drive_ended_.reset();
    number = ++drive_number_;
  }
  move_base_.sendGoal(goal, [this, number](const actionlib::SimpleClientGoalState& state,
                                           const move_base_msgs::MoveBaseResultConstPtr&) {
    {
      const std::lock_guard lock(mutex_);
      if (number != drive_number_) return;
      drive_ended_ = state == actionlib::SimpleClientGoalState::SUCCEEDED;
    }
    changed_.notify_all();
  });
}

Explorer::Drive Explorer::wait(const navigate::Exploration& exploration) {
  const ros::Time give_up = ros::Time::now() + ros::Duration(params_.goal_timeout_s);
  std::uint64_t seen = map().number;
  while (!stopped()) {
    Map newest;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, kLook, [&] { return closing_ || drive_ended_ || map_.number != seen; });
      if (drive_ended_) return *drive_ended_ ? Drive::kReached : Drive::kFailed;
      newest = map_;
    }
    if (ros::Time::now() > give_up) return Drive::kFailed;
    if (newest.number == seen) continue;
    seen = newest.number;
    const auto costs = to_costs(*newest.message);
    if (costs && exploration.is_outdated(*costs)) return Drive::kOutdated;
  }
  return Drive::kStopped;
}

Result<Pose2> Explorer::pose_in(const std::string& map_frame) const {
  try {
    return ros_convert::to_pose2(tf_buffer_
                                     .lookupTransform(map_frame, params_.base_frame, ros::Time(),
                                                      ros::Duration(params_.transform_timeout_s))
                                     .transform);
  } catch (const tf2::TransformException& error) {
    return fail(ErrorCode::kNotFound, "no pose of the robot: " + std::string(error.what()));
  }
}

bool Explorer::stopped() {
  if (server_->isPreemptRequested() || !server_->isActive()) return true;
  if (!deadline_.isZero() && ros::Time::now() > deadline_) return true;
  const std::lock_guard lock(mutex_);
  return closing_;
}

Explorer::Map Explorer::map() const {
  const std::lock_guard lock(mutex_);
  return map_;
}

void Explorer::await_map_after(std::uint64_t number) {
  const auto give_up =
      std::chrono::steady_clock::now() + std::chrono::duration<double>(params_.map_patience_s);
  while (!stopped() && std::chrono::steady_clock::now() < give_up) {
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, kLook, [&] { return closing_ || map_.number > number; })) return;
  }
}

void Explorer::show(const std::vector<Eigen::Vector2d>& points_m, const nav_msgs::OccupancyGrid& map) {
  visualization_msgs::Marker marker;
  marker.header.frame_id = map.header.frame_id;
  marker.header.stamp = ros::Time::now();
  marker.ns = "frontiers";
  marker.type = visualization_msgs::Marker::POINTS;
  marker.action = points_m.empty() ? visualization_msgs::Marker::DELETE : visualization_msgs::Marker::ADD;
  marker.pose.orientation.w = 1;
  marker.scale.x = marker.scale.y = map.info.resolution;
  marker.color.b = marker.color.a = 1;
  marker.points.resize(points_m.size());
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    marker.points[i].x = points_m[i].x();
    marker.points[i].y = points_m[i].y();
  }
  frontier_publisher_.publish(marker);
}

void Explorer::report(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  using Level = diagnostic_msgs::DiagnosticStatus;
  const std::lock_guard lock(mutex_);
  if (!map_.message)
    status.summary(Level::WARN, "no map yet: waiting for " + map_subscriber_.getTopic());
  else
    status.summary(Level::OK, exploring_ ? "exploring" : "waiting for a goal");
  status.add("frontiers left", frontiers_left_);
  status.add("goals reached", goals_reached_);
  status.add("goals failed", goals_failed_);
}

}  // namespace extperfc::ros_explore
