#include "ros/arm/arm_node.hpp"

#include <cmath>
#include <utility>

#include <ros/console.h>
#include <visualization_msgs/MarkerArray.h>

#include "ros/convert/arm.hpp"

namespace extperfc::ros_arm {

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
  auto grasper = Grasper::make(handle, node->motion_execution_);
  if (!grasper) return tl::unexpected(grasper.error());
  node->grasper_ = std::move(*grasper);
  if (params->depth.enabled) {
    auto depth =
        DepthObstacleMonitor::make({node->arms_, node->transforms_, node->scene_, params->world_frame,
                                    [own = node.get()] { own->publish_scene(); }},
                                   params->depth);
    if (!depth) return tl::unexpected(depth.error());
    node->depth_ = std::move(*depth);
  }
  if (params->objects.enabled) {
    auto objects = ObjectMonitor::make({node->arms_, node->transforms_, node->scene_, params->world_frame,
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
      robot_state_(handle, {params.execution.joint_state_timeout_s, params.execution.robot_state}),
      transforms_(arms_, robot_state_, params.transform_timeout_s),
      scene_(transforms_, params.world_frame),
      executor_(handle, arms_, robot_state_, scene_, params.execution, params.controllers),
      planner_({params_, arms_, robot_state_, transforms_, scene_, executor_}),
      motion_execution_(planner_.shared()),
      server_(planner_.shared()),
      reporter_(handle, private_handle, name) {}

ArmNode::~ArmNode() {
  // Running motions end before the members that they use.
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
      handle_, "plan", [this](const auto& goal, const MotionCallbacks& callbacks, auto& result) {
        return plan(goal, callbacks, result);
      });
  move_action_ = std::make_unique<ActionRunner<extperfc::MoveArmAction>>(
      handle_, "move_arm", [this](const auto& goal, const MotionCallbacks& callbacks, auto& result) {
        return move(goal, callbacks, result);
      });
  pick_action_ = std::make_unique<ActionRunner<extperfc::PickAction>>(
      handle_, "pick", [this](const auto& goal, const MotionCallbacks& callbacks, auto& result) {
        return pick(goal, callbacks, result);
      });
  place_action_ = std::make_unique<ActionRunner<extperfc::PlaceAction>>(
      handle_, "place", [this](const auto& goal, const MotionCallbacks& callbacks, auto& result) {
        return place(goal, callbacks, result);
      });
  for (const auto& gripper : params_.grippers)
    joggers_.push_back(std::make_unique<JogServer>(handle_, planner_.shared(), lease_, stops_, gripper));
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

Status ArmNode::plan(const extperfc::PlanGoal& goal, const MotionCallbacks& callbacks,
                     extperfc::PlanResult& result) {
  callbacks.progress("planning", 0.0);
  auto request = planner_.read(goal.request);
  if (!request) return request.error();
  std::optional<Status> stopped;
  request->cancelled = [&] {
    if (!stopped) stopped = callbacks.cancel.reason();
    return stopped.has_value();
  };
  const auto outcome = planner_.plan(*request);
  result.fraction = outcome.fraction;
  result.planning_time = outcome.times.sum_s();
  Status status = stopped ? *stopped : Status{outcome.code, outcome.message};
  note("plan", status);
  if (status.code != ArmCode::kSuccess) return status;
  result.trajectory = ros_convert::to_message(outcome.joints, outcome.points);
  trajectory_publisher_.publish(result.trajectory);
  return status;
}

MotionCallbacks ArmNode::with_stops(const MotionCallbacks& callbacks, const ArmsLease::Hold& hold) {
  MotionCallbacks changed = callbacks;
  changed.cancel.add([this, &hold, stops = stops_.load()]() -> std::optional<Status> {
    if (stops_ != stops) return Status{ArmCode::kCancelled, "stopped by arm/stop"};
    if (hold.superseded()) return Status{ArmCode::kPreempted, "preempted by a newer motion"};
    return std::nullopt;
  });
  changed.planned = [this](const trajectory_msgs::JointTrajectory& trajectory) {
    trajectory_publisher_.publish(trajectory);
  };
  return changed;
}

Status ArmNode::pick(const extperfc::PickGoal& goal, const MotionCallbacks& callbacks,
                     extperfc::PickResult& result) {
  const auto hold = lease_.take();
  const MotionCallbacks stops = with_stops(callbacks, hold);
  const auto cancelled = stops.cancel.reason();
  Status status = cancelled ? *cancelled : grasper_->pick(goal, stops, result);
  publish_scene();
  note("pick", status);
  return status;
}

Status ArmNode::place(const extperfc::PlaceGoal& goal, const MotionCallbacks& callbacks,
                      extperfc::PlaceResult& result) {
  const auto hold = lease_.take();
  const MotionCallbacks stops = with_stops(callbacks, hold);
  const auto cancelled = stops.cancel.reason();
  Status status = cancelled ? *cancelled : grasper_->place(goal, stops, result);
  publish_scene();
  note("place", status);
  return status;
}

Status ArmNode::move(const extperfc::MoveArmGoal& goal, const MotionCallbacks& callbacks,
                     extperfc::MoveArmResult& result) {
  const auto hold = lease_.take();
  const MotionCallbacks stops = with_stops(callbacks, hold);
  if (const auto cancelled = stops.cancel.reason()) return *cancelled;
  Moved moved;
  if (!goal.trajectory.points.empty() || !goal.trajectory.joint_names.empty()) {
    moved = motion_execution_.execute(goal.trajectory, stops);
  } else if (auto request = motion_execution_.read(goal.request); !request) {
    moved.status = request.error();
  } else {
    moved = motion_execution_.move(std::move(*request), goal.replans, stops);
  }
  result.trajectory = std::move(moved.trajectory);
  result.fraction = moved.fraction;
  result.executed = moved.executed;
  result.replans = moved.replans;
  note("move_arm", moved.status);
  return moved.status;
}

void ArmNode::note(const char* what, const Status& status) {
  const std::lock_guard lock(note_mutex_);
  last_ = std::string(what) + ": " + to_string(status.code) +
          (status.message.empty() ? "" : ", " + status.message);
  last_failed_ = status.code != ArmCode::kSuccess;
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
    response.code = ros_convert::to_message(code);
    response.message = message;
    return true;
  };
  const auto state = server_.read_start(request.joints);
  if (!state) return answer(state.error().code, state.error().message);
  const auto world = scene_.world();
  if (!world) return answer(world.error().code, world.error().message);
  auto checker = server_.pipeline().checker(request.group, *state, *world, false);
  if (!checker) return answer(ArmCode::kInvalidRequest, checker.error().message);
  const auto values = arm::RobotArms::select(**arms_.group(request.group), *state);
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
  const auto answer = [&](const Status& status) {
    response.code = ros_convert::to_message(status.code);
    response.message = status.message;
    return true;
  };
  const auto read = server_.read(asked);
  if (!read) return answer(read.error());
  auto world = request.avoid_collisions != 0 ? scene_.world() : arm::CollisionWorld{};
  if (!world) return answer(world.error());
  const auto solved = server_.pipeline().solve(*read, *world, request.avoid_collisions != 0);
  if (solved.code == ArmCode::kSuccess) response.joints = ros_convert::to_message(solved.joints);
  return answer({solved.code, solved.message});
}

bool ArmNode::on_stop(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  ++stops_;
  response.success = 1U;
  response.message = "stopping all motions of the arms";
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
  if (const auto positions = robot_state_.positions(); !positions)
    status.mergeSummary(DiagnosticStatus::WARN, positions.error().message);
  if (const auto not_ready = robot_state_.not_ready_reason())
    status.mergeSummary(DiagnosticStatus::WARN, not_ready->message);
  status.add("changes of the scene", scene_.version());
}

}  // namespace extperfc::ros_arm
