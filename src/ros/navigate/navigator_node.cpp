#include "ros/navigate/navigator_node.hpp"

#include <cmath>
#include <exception>
#include <utility>

#include <nav_msgs/Path.h>
#include <ros/console.h>
#include <ros/init.h>

#include "extperfc/base/stopwatch.hpp"

#include "ros/convert/geometry.hpp"
#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_navigate {

namespace {

using navigate::NavCode;
using navigate::NavEnd;
using navigate::NavError;

constexpr double kPollS = 0.002;  // of wall time, while simulated time is waited for
constexpr double kShowS = 0.1;    // between feedbacks
constexpr double kSettleS = 0.6;  // after odometry jumped, for the localizer
constexpr double kTimeRanBackS = 0.1;

ros::NodeHandle with_queue(const ros::NodeHandle& handle, ros::CallbackQueue& queue) {
  ros::NodeHandle own(handle);
  own.setCallbackQueue(&queue);
  return own;
}

/// What may be changed while the node runs.
const std::vector<ros_params::DynamicParam>& dynamic_params() {
  static const std::vector<ros_params::DynamicParam> params{
      {"controller_frequency", "Hz, of the control cycle", {}},
      {"planner_frequency", "Hz, of plans while driving; 0: only when needed", {}},
      {"planner_patience", "s without a plan until a recovery begins", {}},
      {"controller_patience", "s without a velocity until a recovery begins", {}},
      {"oscillation_timeout", "s without progress until a recovery begins; 0: never", {}},
      {"oscillation_distance", "m that count as progress", {}},
      {"recovery_behavior_enabled", "false: a goal fails at the first cause", {}},
      {"xy_goal_tolerance", "m", {}},
      {"yaw_goal_tolerance", "rad", {}},
      {"max_vel_x", "m/s forwards", {}},
      {"min_vel_x", "m/s, negative: backwards", {}},
      {"max_vel_y", "m/s sideways", {}},
      {"max_vel_theta", "rad/s", {}},
      {"acc_lim_x", "m/s^2", {}},
      {"acc_lim_y", "m/s^2", {}},
      {"acc_lim_theta", "rad/s^2", {}},
      {"footprint_padding", "m", {}},
      {"inflation_radius", "m", {}},
      {"cost_scaling_factor", "1/m, how fast costs fall with the distance", {}},
      {"allow_unknown", "plan through unknown space", {}},
      {"default_tolerance", "m that a blocked goal may be moved", {}},
      {"path_distance_bias", "weight of the distance from the path", {}},
      {"path_heading_bias", "weight of the difference from the path's heading", {}},
      {"goal_distance_bias", "weight of progress", {}},
      {"occdist_scale", "weight of cells' costs", {}},
      {"people_scale", "weight of predicted people", {}},
      {"smooth_scale", "weight of changes of velocity", {}}};
  return params;
}

}  // namespace

Result<std::unique_ptr<NavigatorNode>> NavigatorNode::make(const ros::NodeHandle& handle,
                                                           const ros::NodeHandle& private_handle,
                                                           const std::string& name) {
  auto params = ros_params::load_navigator_params(private_handle);
  if (!params) return tl::unexpected(params.error());
  for (const auto& note : params->notes) ROS_WARN("%s: %s", name.c_str(), note.c_str());
  std::unique_ptr<NavigatorNode> node(new NavigatorNode(handle, private_handle, std::move(*params), name));
  if (auto started = node->start(); !started) return tl::unexpected(started.error());
  return node;
}

NavigatorNode::NavigatorNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                             ros_params::NavigatorNodeParams params, const std::string& name)
    : handle_(with_queue(handle, queue_)),
      private_handle_(with_queue(private_handle, queue_)),
      server_handle_(handle_, "move_base"),
      params_(std::move(params)),
      tf_listener_(std::make_unique<tf2_ros::TransformListener>(tf_buffer_)),
      poses_(handle_, params_, tf_buffer_),
      outline_(handle_, private_handle_, params_),
      people_(params_.people),
      tracks_publisher_(server_handle_.advertise<TrackArray>("people_tracks", 1)),
      costs_(handle_, params_, tf_buffer_,
             {[this](const PlacedScan& placed) { on_scan(placed); },
              [this](const OccupancyGrid& map) { people_.set_map(map); },
              [this](double now_s) { return people_.people(now_s); },
              [this](double now_s) { return people_.passers(now_s); }}),
      display_(server_handle_, params_.global_frame, params_.odom_frame),
      global_publisher_(server_handle_, "global_costmap/costmap", params_.global_frame),
      local_publisher_(server_handle_, "local_costmap/costmap", params_.odom_frame),
      reporter_(std::make_unique<ros_health::Reporter>(handle_, private_handle_, name)) {
  if (!outline_.problem().empty()) ROS_WARN("%s: %s", name.c_str(), outline_.problem().c_str());
}

/// Callbacks end first: they use what follows.
NavigatorNode::~NavigatorNode() {
  stopping_ = true;
  if (control_thread_.joinable()) control_thread_.join();
  spinner_.stop();
  queue_.disable();
  reporter_.reset();
  reconfigure_.reset();
  plan_service_.shutdown();
  clear_service_.shutdown();
  goals_.reset();
  planning_.reset();
  costs_.stop();
  guard_.reset();  // zero, if it was driving
}

Result<void> NavigatorNode::start() {
  auto local = plugins_.local(params_);
  if (!local) return tl::unexpected(local.error());
  auto global = plugins_.global(params_);
  if (!global) return tl::unexpected(global.error());
  navigator_ = std::make_unique<navigate::Navigator>(params_.navigator, std::move(*local));
  controller_period_s_ = 1 / params_.controller_frequency_hz;
  planning_ = std::make_unique<PlanWorker>(
      std::move(*global),
      [this] {
        return PlanWorker::Scene{costs_.global(), outline_.bare(), params_.global.base};
      },
      [this](navigate::PlanAnswer answer) {
        const std::lock_guard lock(mutex_);
        navigator_->set_plan(std::move(answer));
      });
  velocity_publisher_ = handle_.advertise<geometry_msgs::Twist>("cmd_vel", 1);
  guard_ = std::make_unique<GuardThread>(
      params_.guard, params_.guard_memory_m,
      [this](const Twist2& velocity) { velocity_publisher_.publish(ros_convert::to_message(velocity)); });
  if (auto started = costs_.start(); !started) return started;
  advertise();
  spinner_.start();
  control_thread_ = std::thread([this] { control_loop(); });
  return {};
}

void NavigatorNode::on_scan(const PlacedScan& placed) {
  guard_->set_points(navigate::surface_points(placed.scan), placed.scan.stamp_s, *outline_.footprint(),
                     placed.odom_T_base);
  people_.update(placed);
  if (tracks_publisher_.getNumSubscribers() > 0)
    tracks_publisher_.publish(people_.tracks(params_.odom_frame));
}

void NavigatorNode::advertise() {
  status_publisher_ = handle_.advertise<NavigationStatus>("navigation_status", 1, true);
  plan_service_ = server_handle_.advertiseService("make_plan", &NavigatorNode::on_make_plan, this);
  clear_service_ = server_handle_.advertiseService("clear_costmaps", &NavigatorNode::on_clear, this);
  reconfigure_ = std::make_unique<ros_params::Reconfigure>(private_handle_, params_.read, dynamic_params(),
                                                           [this] { return apply_params(); });
  goals_ = std::make_unique<GoalServer>(
      handle_, GoalServer::Callbacks{[this](const auto& pose) { return to_global(pose); },
                                     [this](const auto& task) { start_task(task); },
                                     [this](std::uint64_t task) { cancel_task(task); }});
  reporter_->add("navigator", [this](auto& status) { report(status); });
  reporter_->add("cost maps", [this](auto& status) { costs_.report(status, params_.timeout_s); });
  reporter_->add("global planner", [this](auto& status) {
    status.summary(diagnostic_msgs::DiagnosticStatus::OK, "running");
    planning_->report(status);
  });
  reporter_->start();
}

Result<void> NavigatorNode::apply_params() {
  auto params = ros_params::load_navigator_params(private_handle_);
  if (!params) return tl::unexpected(params.error());
  auto local = plugins_.local(*params);
  if (!local) return tl::unexpected(local.error());
  auto global = plugins_.global(*params);
  if (!global) return tl::unexpected(global.error());
  planning_->set_planner(std::move(*global));
  outline_.set_params(*params);
  costs_.set_costs(params->costs);
  costs_.set_limits(params->limits);
  poses_.set_limits(params->limits);
  controller_period_s_ = 1 / params->controller_frequency_hz;
  const std::lock_guard lock(mutex_);
  navigator_->set_params(params->navigator);
  navigator_->set_planner(std::move(*local));
  return {};
}

void NavigatorNode::control_loop() {
  ros::Time due = ros::Time::now();
  while (!stopping_) {
    if (!wait_until(due)) continue;
    const auto now = ros::Time::now();
    if (now.toSec() < last_now_.toSec() - kTimeRanBackS) time_ran_back();
    last_now_ = now;
    due = now + ros::Duration(controller_period_s_);
    const Stopwatch watch;
    try {
      cycle(now);
      cycle_health_.done(watch.milliseconds(), watch.milliseconds());
    } catch (const std::exception& error) {
      guard_->command({{}, {}, outline_.bare(), now.toSec(), false});
      if (cycle_health_.failed(error.what())) ROS_ERROR("control cycle: %s", error.what());
    }
  }
}

/// False: not yet. By wall time, because simulated time may stand still or run back.
bool NavigatorNode::wait_until(const ros::Time& due) {
  const double left_s = due.toSec() - ros::Time::now().toSec();
  const double period_s = controller_period_s_;
  if (left_s <= 0 || left_s > period_s + kTimeRanBackS) return true;
  ros::WallDuration(ros::Time::isSimTime() ? kPollS : std::min(left_s, period_s)).sleep();
  return false;
}

void NavigatorNode::time_ran_back() {
  ROS_WARN("time ran back: forgetting transforms and what sensors saw");
  tf_buffer_.clear();
  poses_.forget();
  costs_.forget();
  people_.forget();
  shown_ = maps_shown_ = settled_ = ros::Time();
}

void NavigatorNode::cycle(const ros::Time& now) {
  const auto state = poses_.state(now);
  const auto costs = costs_.local();
  const auto footprint = outline_.footprint();
  if (footprint != footprint_) costs_.set_footprint(*footprint);
  footprint_ = footprint;
  if (state.odom_jumped) settled_ = now + ros::Duration(kSettleS);
  if (state.jumped) {
    ROS_WARN("the pose jumped%s: forgetting what sensors saw", state.odom_jumped ? " in odometry" : "");
    costs_.clear();
  }
  auto input = gather(now, state, costs, footprint);
  navigate::NavigatorOutput output;
  {
    const std::lock_guard lock(mutex_);
    output = navigator_->update(input);
  }
  send(output, state);
  act(output, now);
  show(output, state, now);
}

navigate::NavigatorInput NavigatorNode::gather(const ros::Time& now, const RobotState& state,
                                               const CostMaps::GridPtr& costs,
                                               const OutlineMonitor::FootprintPtr& footprint) {
  navigate::NavigatorInput input;
  input.now_s = now.toSec();
  input.fault = state.fault;
  if (!input.fault) input.fault = costs_.fault(now);
  if (!input.fault && now < settled_)
    input.fault = NavError{NavCode::kLocalizationLost, "odometry jumped: waiting for the localizer"};
  input.map_T_base = state.map_T_base;
  input.odom_T_base = state.odom_T_base;
  input.velocity = state.velocity;
  input.costs = costs.get();
  input.footprint = footprint.get();
  input.map_changed = costs_.take_map_changed();
  input.jumped = state.jumped;
  if (!input.fault) input.speed_factor = costs_.speed_factor(state.map_T_base);
  input.people = people_.people(input.now_s);
  input.guard_stopped = sending_ && guard_->stopped();
  input.with_candidates = display_.wants_candidates();
  return input;
}

void NavigatorNode::send(const navigate::NavigatorOutput& output, const RobotState& state) {
  if (!output.active && !sending_) return;
  sending_ = output.active;
  guard_->command({output.command, state.velocity, outline_.bare(), state.stamp.toSec(), !output.active});
}

void NavigatorNode::act(navigate::NavigatorOutput& output, const ros::Time& now) {
  if (!output.event.empty()) ROS_INFO("navigator: %s", output.event.c_str());
  if (output.plan) planning_->ask(std::move(*output.plan));
  if (output.clear_beyond_m) costs_.clear(*output.clear_beyond_m);
  if (output.new_path) display_.global_plan(*output.new_path, now);
  if (output.end) finish(*output.end);
}

void NavigatorNode::finish(const NavEnd& end) {
  {
    const std::lock_guard lock(mutex_);
    last_end_ = end.error;
    if (active_task_ == end.task) active_task_.reset();
  }
  if (end.error.code == NavCode::kSuccess)
    ROS_INFO("navigator: %s", end.error.message.c_str());
  else
    ROS_WARN("navigator: %s: %s", to_string(end.error.code), end.error.message.c_str());
  goals_->finish(end);
}

void NavigatorNode::show(const navigate::NavigatorOutput& output, const RobotState& state,
                         const ros::Time& now) {
  if (!output.trajectory.empty()) display_.local_plan(output.trajectory, now);
  if (display_.wants_candidates()) display_.candidates(output.candidates, now);
  display_.people(people_.people(now.toSec()), now);
  if (std::abs((now - shown_).toSec()) >= kShowS || output.end) {
    shown_ = now;
    if (!state.fault) display_.footprint(*footprint_, state.odom_T_base, now);
    publish_status(state, now);
  }
  const double publish_hz = params_.costs.publish_hz;
  if (publish_hz <= 0 || std::abs((now - maps_shown_).toSec()) * publish_hz < 1) return;
  maps_shown_ = now;
  local_publisher_.publish(costs_.local(), now);
  if (global_publisher_.wanted()) global_publisher_.publish(costs_.global(), now);
}

void NavigatorNode::publish_status(const RobotState& state, const ros::Time& now) {
  NavigationStatus status;
  geometry_msgs::PoseStamped base;
  status.header.stamp = base.header.stamp = now;
  status.header.frame_id = base.header.frame_id = params_.global_frame;
  base.pose = ros_convert::to_pose_message(state.map_T_base);
  bool active = false;
  {
    const std::lock_guard lock(mutex_);
    active = navigator_->active();
    status.state = to_string(navigator_->state());
    status.code = static_cast<std::int32_t>(last_end_.code);
    status.message = last_end_.message;
    status.reason = navigator_->reason();
    status.waypoint = static_cast<std::uint32_t>(navigator_->goal_index());
    status.recoveries = static_cast<std::uint32_t>(navigator_->recoveries());
    status.distance_left = navigator_->distance_left_m();
    status.speed = std::hypot(state.velocity.vx, state.velocity.vy);
  }
  status_publisher_.publish(status);
  if (active && !state.fault) goals_->feedback(base, status.waypoint, status.distance_left);
}

navigate::NavResult<Pose2> NavigatorNode::to_global(const geometry_msgs::PoseStamped& pose) {
  const auto planar = ros_convert::to_pose2(pose.pose);
  if (!planar) return navigate::nav_fail(NavCode::kInvalidRequest, planar.error().message);
  const auto frame = ros_convert::without_slash(pose.header.frame_id);
  if (frame.empty() || frame == params_.global_frame) return *planar;
  try {
    const auto transform = tf_buffer_.lookupTransform(params_.global_frame, frame, ros::Time(0));
    const auto global_T_frame = ros_convert::to_pose2(transform.transform);
    if (global_T_frame) return compose(*global_T_frame, *planar);
    return navigate::nav_fail(NavCode::kInvalidRequest, global_T_frame.error().message);
  } catch (const tf2::TransformException& error) {
    return navigate::nav_fail(NavCode::kInvalidRequest, "no transform from the frame '" + frame + "' to " +
                                                            params_.global_frame + ": " + error.what());
  }
}

void NavigatorNode::start_task(const navigate::NavTask& task) {
  std::optional<NavEnd> replaced;
  {
    const std::lock_guard lock(mutex_);
    replaced = navigator_->start(task);
    active_task_ = task.id;
  }
  if (!task.goals.empty()) display_.goal(task.goals.front(), ros::Time::now());
  if (replaced) goals_->finish(*replaced);
}

void NavigatorNode::cancel_task(std::uint64_t task) {
  std::optional<NavEnd> end;
  {
    const std::lock_guard lock(mutex_);
    if (active_task_ == task) end = navigator_->cancel();
  }
  if (end) finish(*end);
}

bool NavigatorNode::on_make_plan(nav_msgs::GetPlan::Request& request, nav_msgs::GetPlan::Response& response) {
  response.plan.header.frame_id = params_.global_frame;
  response.plan.header.stamp = ros::Time::now();
  navigate::PlanRequest plan;
  auto start = request.start;
  if (start.header.frame_id.empty()) {  // as move_base: from where the robot is
    start = {};
    start.header.frame_id = params_.base_frame;
    start.pose.orientation.w = 1;
  }
  const auto from = to_global(start);
  const auto to = to_global(request.goal);
  plan.tolerance_m =
      std::isfinite(request.tolerance) ? std::max(0.0, static_cast<double>(request.tolerance)) : 0;
  if (from) plan.start = *from;
  if (to) plan.goal = *to;
  const auto path =
      !from ? tl::unexpected(from.error()) : (!to ? tl::unexpected(to.error()) : planning_->plan_now(plan));
  if (!path) {
    constexpr double kQuietS = 5;  // an explorer asks for plans to dozens of places at once
    ROS_WARN_THROTTLE(kQuietS, "make_plan: %s: %s", to_string(path.error().code),
                      path.error().message.c_str());
    return true;
  }
  for (const auto& pose : path->poses) {
    geometry_msgs::PoseStamped one;
    one.header = response.plan.header;
    one.pose = ros_convert::to_pose_message(pose);
    response.plan.poses.push_back(one);
  }
  return true;
}

bool NavigatorNode::on_clear(std_srvs::Empty::Request&, std_srvs::Empty::Response&) {
  costs_.clear();
  return true;
}

void NavigatorNode::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  std::string reason;
  {
    const std::lock_guard lock(mutex_);
    status.summary(DiagnosticStatus::OK, to_string(navigator_->state()));
    reason = navigator_->reason();
    status.add("state", to_string(navigator_->state()));
    status.add("waypoint", navigator_->goal_index());
    status.addf("distance left [m]", "%.2f", navigator_->distance_left_m());
    status.add("recoveries", navigator_->recoveries());
    status.add("last code", to_string(last_end_.code));
    status.add("last message", last_end_.message);
  }
  status.add("reason", reason);
  status.add("collision guard", guard_->reason());
  status.addf("arms beyond the footprint [m]", "%.3f", outline_.overhang_m());
  poses_.report(status, params_.timeout_s);
  cycle_health_.report(status);
  if (!reason.empty()) status.mergeSummary(DiagnosticStatus::WARN, reason);
}

}  // namespace extperfc::ros_navigate
