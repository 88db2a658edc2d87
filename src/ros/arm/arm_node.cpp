#include "ros/arm/arm_node.hpp"

#include <cmath>
#include <utility>

#include <ros/console.h>
#include <visualization_msgs/MarkerArray.h>

#include "ros/convert/arm.hpp"

namespace extperfc::arm_node {

using arm::ArmCode;
using ros_params::ArmNodeParams;

namespace {

Result<arm::RobotArms> read_robot(const ArmNodeParams& params) {
  auto robot = RobotModel::from_urdf(params.urdf, ros_params::package_folder());
  if (!robot) return fail(robot.error().code, "robot description: " + robot.error().message);
  auto srdf = arm::read_srdf(params.srdf_file);
  if (!srdf) return fail(srdf.error().code, "SRDF " + params.srdf_file + ": " + srdf.error().message);
  return arm::RobotArms::make(*robot, *srdf, params.robot);
}

}  // namespace

Result<std::unique_ptr<ArmNode>> ArmNode::make(const ros::NodeHandle& handle,
                                               const ros::NodeHandle& private_handle,
                                               const std::string& name) {
  const auto params = ros_params::load_arm_params(private_handle);
  if (!params) return tl::unexpected(params.error());
  auto arms = read_robot(*params);
  if (!arms) return tl::unexpected(arms.error());
  std::unique_ptr<ArmNode> node(new ArmNode(handle, private_handle, *params, std::move(*arms), name));
  if (auto fits = node->executor_.check(); !fits) return tl::unexpected(fits.error());
  auto grasper = Grasper::make(handle, node->mover_);
  if (!grasper) return tl::unexpected(grasper.error());
  node->grasper_ = std::move(*grasper);
  if (params->depth.enabled) {
    auto depth = DepthWatch::make({node->arms_, node->frames_, node->scene_, params->world_frame,
                                   [own = node.get()] { own->publish_scene(); }},
                                  params->depth);
    if (!depth) return tl::unexpected(depth.error());
    node->depth_ = std::move(*depth);
  }
  if (params->objects.enabled) {
    auto objects = ObjectWatch::make({node->arms_, node->frames_, node->scene_, params->world_frame,
                                      [own = node.get()] { own->on_scene_changed(); }},
                                     params->objects);
    if (!objects) return tl::unexpected(objects.error());
    node->objects_ = std::move(*objects);
  }
  node->advertise();
  return node;
}

ArmNode::ArmNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                 const ArmNodeParams& params, arm::RobotArms arms, const std::string& name)
    : handle_(handle),
      params_(params),
      arms_(std::move(arms)),
      watch_(handle, {params.execution.joint_state_timeout_s, params.execution.robot_state}),
      frames_(arms_, watch_, params.transform_timeout_s),
      scene_(frames_, params.world_frame),
      executor_(handle, arms_, watch_, scene_, params.execution, params.controllers),
      planner_({params_, arms_, watch_, frames_, scene_, executor_}),
      mover_(planner_.shared()),
      server_(planner_.shared()),
      reporter_(handle, private_handle, name) {}

ArmNode::~ArmNode() {
  // First what runs, then what it uses.
  ++stops_;
  joggers_.clear();
  place_action_.reset();
  pick_action_.reset();
  move_action_.reset();
  plan_action_.reset();
}

void ArmNode::advertise() {
  trajectory_publisher_ =
      handle_.advertise<trajectory_msgs::JointTrajectory>("arm/display_trajectory", 1, true);
  marker_publisher_ = handle_.advertise<visualization_msgs::MarkerArray>("arm/markers", 1, true);
  services_ = {handle_.advertiseService("arm/apply_scene", &ArmNode::on_apply_scene, this),
               handle_.advertiseService("arm/get_scene", &ArmNode::on_get_scene, this),
               handle_.advertiseService("arm/check_state", &ArmNode::on_check_state, this),
               handle_.advertiseService("arm/solve_ik", &ArmNode::on_solve_ik, this),
               handle_.advertiseService("arm/clear_depth", &ArmNode::on_clear_depth, this),
               handle_.advertiseService("arm/stop", &ArmNode::on_stop, this)};
  plan_action_ = std::make_unique<ActionRunner<extperfc::PlanAction>>(
      handle_, "plan",
      [this](const auto& goal, const Hooks& hooks, auto& result) { return plan(goal, hooks, result); });
  move_action_ = std::make_unique<ActionRunner<extperfc::MoveArmAction>>(
      handle_, "move_arm",
      [this](const auto& goal, const Hooks& hooks, auto& result) { return move(goal, hooks, result); });
  pick_action_ = std::make_unique<ActionRunner<extperfc::PickAction>>(
      handle_, "pick",
      [this](const auto& goal, const Hooks& hooks, auto& result) { return pick(goal, hooks, result); });
  place_action_ = std::make_unique<ActionRunner<extperfc::PlaceAction>>(
      handle_, "place",
      [this](const auto& goal, const Hooks& hooks, auto& result) { return place(goal, hooks, result); });
  for (const auto& hand : params_.hands)
    joggers_.push_back(std::make_unique<JogServer>(handle_, planner_.shared(), lease_, stops_, hand));
  reporter_.add("arms", [this](diagnostic_updater::DiagnosticStatusWrapper& status) { report(status); });
  if (depth_)
    reporter_.add("depth",
                  [this](diagnostic_updater::DiagnosticStatusWrapper& status) { depth_->report(status); });
  if (objects_)
    reporter_.add("objects",
                  [this](diagnostic_updater::DiagnosticStatusWrapper& status) { objects_->report(status); });
  reporter_.start();
  if (depth_) depth_->start(handle_);
  if (objects_) objects_->start(handle_);
}

Ending ArmNode::plan(const extperfc::PlanGoal& goal, const Hooks& hooks, extperfc::PlanResult& result) {
  hooks.progress("planning", 0.0);
  auto request = planner_.read(goal.request);
  if (!request) return request.error();
  std::optional<Ending> stopped;
  request->cancelled = [&] {
    if (!stopped) stopped = hooks.interrupted();
    return stopped.has_value();
  };
  const auto outcome = planner_.plan(*request);
  result.fraction = outcome.fraction;
  result.planning_time = outcome.times.sum_s();
  Ending ending = stopped ? *stopped : Ending{outcome.code, outcome.message};
  note("plan", ending);
  if (ending.code != ArmCode::kSuccess) return ending;
  result.trajectory = convert::to_message(outcome.joints, outcome.points);
  trajectory_publisher_.publish(result.trajectory);
  return ending;
}

Hooks ArmNode::with_stops(const Hooks& hooks, const ArmsLease::Hold& hold) {
  const auto stops = stops_.load();
  return {[this, &hooks, &hold, stops]() -> std::optional<Ending> {
            if (stops_ != stops) return Ending{ArmCode::kCancelled, "stopped by arm/stop"};
            if (hold.superseded()) return Ending{ArmCode::kPreempted, "a newer motion was asked for"};
            return hooks.interrupted();
          },
          hooks.progress,
          {},
          [this](const trajectory_msgs::JointTrajectory& trajectory) {
            trajectory_publisher_.publish(trajectory);
          }};
}

Ending ArmNode::pick(const extperfc::PickGoal& goal, const Hooks& hooks, extperfc::PickResult& result) {
  const auto hold = lease_.take();
  const Hooks stops = with_stops(hooks, hold);
  const auto interrupted = stops.interrupted();
  Ending ending = interrupted ? *interrupted : grasper_->pick(goal, stops, result);
  publish_scene();
  note("pick", ending);
  return ending;
}

Ending ArmNode::place(const extperfc::PlaceGoal& goal, const Hooks& hooks, extperfc::PlaceResult& result) {
  const auto hold = lease_.take();
  const Hooks stops = with_stops(hooks, hold);
  const auto interrupted = stops.interrupted();
  Ending ending = interrupted ? *interrupted : grasper_->place(goal, stops, result);
  publish_scene();
  note("place", ending);
  return ending;
}

Ending ArmNode::move(const extperfc::MoveArmGoal& goal, const Hooks& hooks, extperfc::MoveArmResult& result) {
  const auto hold = lease_.take();
  const Hooks stops = with_stops(hooks, hold);
  if (const auto ended = stops.interrupted()) return *ended;
  Moved moved;
  if (!goal.trajectory.points.empty() || !goal.trajectory.joint_names.empty()) {
    moved = mover_.execute(goal.trajectory, stops);
  } else if (auto request = mover_.read(goal.request); !request) {
    moved.ending = request.error();
  } else {
    moved = mover_.move(std::move(*request), goal.replans, stops);
  }
  result.trajectory = std::move(moved.trajectory);
  result.fraction = moved.fraction;
  result.executed = moved.executed;
  result.replans = moved.replans;
  note("move_arm", moved.ending);
  return moved.ending;
}

void ArmNode::note(const char* what, const Ending& ending) {
  const std::lock_guard lock(note_mutex_);
  last_ = std::string(what) + ": " + to_string(ending.code) +
          (ending.message.empty() ? "" : ", " + ending.message);
  last_failed_ = ending.code != ArmCode::kSuccess;
  if (last_failed_)
    ROS_WARN_STREAM(last_);
  else
    ROS_INFO_STREAM(last_);
}

bool ArmNode::on_apply_scene(extperfc::ApplyScene::Request& request,
                             extperfc::ApplyScene::Response& response) {
  const auto applied = scene_.apply(request.objects);
  response.success = static_cast<std::uint8_t>(applied.has_value());
  response.message = applied ? "" : applied.error().message;
  if (!applied) return true;
  for (const auto& object : request.objects)
    if (object.operation == extperfc::SceneObject::REMOVE && object.name.empty() && depth_) depth_->clear();
  on_scene_changed();
  return true;
}

void ArmNode::on_scene_changed() {
  if (depth_) depth_->scene_changed();
  publish_scene();
}

bool ArmNode::on_clear_depth(std_srvs::Empty::Request&, std_srvs::Empty::Response&) {
  if (depth_) depth_->clear();
  return true;
}

bool ArmNode::on_get_scene(extperfc::GetScene::Request&, extperfc::GetScene::Response& response) {
  if (auto objects = scene_.messages()) response.objects = std::move(*objects);
  return true;
}

bool ArmNode::on_check_state(extperfc::CheckArmState::Request& request,
                             extperfc::CheckArmState::Response& response) {
  const std::lock_guard lock(service_mutex_);
  const auto answer = [&](ArmCode code, const std::string& message) {
    response.code = static_cast<int>(code);
    response.message = message;
    return true;
  };
  extperfc::ArmRequest asked;
  asked.group = request.group;
  asked.start = request.joints;
  asked.named_state = "-";  // no goal is needed to look at a start
  const auto state = server_.read(asked);
  if (!state) return answer(state.error().code, state.error().message);
  const auto world = scene_.world();
  if (!world) return answer(world.error().code, world.error().message);
  auto checker = server_.pipeline().checker(request.group, state->start, *world, false);
  if (!checker) return answer(ArmCode::kInvalidRequest, checker.error().message);
  const auto values = arm::RobotArms::select(**arms_.group(request.group), state->start);
  if (!values) return answer(ArmCode::kNoJointStates, values.error().message);
  if (const auto nearest = checker->nearest(*values)) {
    response.first = nearest->first;
    response.second = nearest->second;
    response.distance = nearest->distance_m;
  }
  const auto& limits = checker->model().limits();
  for (Eigen::Index i = 0; i < values->size(); ++i)
    if ((*values)[i] < limits.lower[i] || (*values)[i] > limits.upper[i])
      return answer(ArmCode::kStartOutsideLimits,
                    checker->model().joint_names()[static_cast<std::size_t>(i)] + " is outside its limits");
  if (!checker->is_free(*values))
    return answer(ArmCode::kStartInCollision, response.first + " touches " + response.second);
  return answer(ArmCode::kSuccess, "free");
}

bool ArmNode::on_solve_ik(extperfc::SolveArmIk::Request& request, extperfc::SolveArmIk::Response& response) {
  const std::lock_guard lock(service_mutex_);
  extperfc::ArmRequest asked;
  asked.group = request.group;
  asked.start = request.seed;
  asked.tool_goals = {request.goal};
  const auto answer = [&](const Ending& ending) {
    response.code = static_cast<int>(ending.code);
    response.message = ending.message;
    return true;
  };
  const auto read = server_.read(asked);
  if (!read) return answer(read.error());
  auto world = request.avoid_collisions != 0 ? scene_.world() : arm::CollisionWorld{};
  if (!world) return answer(world.error());
  const auto solved = server_.pipeline().solve(*read, *world, request.avoid_collisions != 0);
  if (solved.code == ArmCode::kSuccess) response.joints = convert::to_message(solved.joints);
  return answer({solved.code, solved.message});
}

bool ArmNode::on_stop(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  ++stops_;
  response.success = 1U;
  response.message = "whatever moves stops";
  return true;
}

void ArmNode::publish_scene() {
  marker_publisher_.publish(scene_.markers(arms_.root_link()));
}

void ArmNode::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  status.summary(DiagnosticStatus::OK, "ready");
  {
    const std::lock_guard lock(note_mutex_);
    status.add("last request", last_.empty() ? "none" : last_);
  }
  if (const auto positions = watch_.positions(); !positions)
    status.mergeSummary(DiagnosticStatus::WARN, positions.error().message);
  if (const auto obstacle = watch_.obstacle()) status.mergeSummary(DiagnosticStatus::WARN, obstacle->message);
  status.add("changes of the scene", scene_.version());
}

}  // namespace extperfc::arm_node
