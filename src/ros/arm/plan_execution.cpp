#include "ros/arm/plan_execution.hpp"

#include <chrono>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>

#include "ros/convert/arm.hpp"

namespace extperfc::ros_arm {

using arm::ArmCode;
using arm::MotionOutcome;
using arm::MotionRequest;
using extperfc::ArmRequest;
using extperfc::ToolGoal;

namespace {

constexpr double kExact = 1e-4;  // [m] or [rad], used for a tolerance of 0
// Voxels that an arm has moved into since the latest image are cleared by the next one.
constexpr auto kClearing = std::chrono::seconds(1);
constexpr auto kClearingStep = std::chrono::milliseconds(100);

constexpr bool is(arm::ToolConstraintKind kind, int constant) {
  return static_cast<int>(kind) == constant;
}
static_assert(is(arm::ToolConstraintKind::kKeepAxis, extperfc::ToolConstraint::KEEP_AXIS));
static_assert(is(arm::ToolConstraintKind::kKeepPlane, extperfc::ToolConstraint::KEEP_PLANE));
static_assert(is(arm::ToolConstraintKind::kKeepLine, extperfc::ToolConstraint::KEEP_LINE));
static_assert(is(arm::ToolConstraintKind::kKeepOrientation, extperfc::ToolConstraint::KEEP_ORIENTATION));
static_assert(is(arm::ToolConstraintKind::kKeepRelative, extperfc::ToolConstraint::KEEP_RELATIVE));

tl::expected<Eigen::Vector3d, Status> tolerance(const geometry_msgs::Vector3& message, double free_from) {
  Eigen::Vector3d tolerance(message.x, message.y, message.z);
  for (auto& value : tolerance) {
    if (!(value >= 0.0))
      return failure(ArmCode::kInvalidRequest, "tolerances of the goal must not be negative or NaN");
    if (value == 0.0) value = kExact;
    if (value >= free_from) value = std::numeric_limits<double>::infinity();
  }
  return tolerance;
}

tl::expected<arm::ToolTarget, Status> to_target(const ToolGoal& message, const TransformLookup& transforms) {
  arm::ToolTarget target;
  target.link = message.link;
  const auto pose = transforms.root_T_pose(message.pose);
  if (!pose) return tl::unexpected(pose.error());
  target.root_T_tool = *pose;
  const auto position = tolerance(message.position_tolerance, std::numeric_limits<double>::infinity());
  if (!position) return tl::unexpected(position.error());
  const auto orientation = tolerance(message.orientation_tolerance, M_PI);
  if (!orientation) return tl::unexpected(orientation.error());
  target.tolerance = {*position, *orientation};
  return target;
}

tl::expected<void, Status> read_goal(const ArmRequest& message, const TransformLookup& transforms,
                                     MotionRequest* request) {
  const int goals = (message.named_state.empty() ? 0 : 1) + (message.joint_goal.name.empty() ? 0 : 1) +
                    (message.tool_goals.empty() ? 0 : 1);
  if (goals != 1)
    return failure(ArmCode::kInvalidRequest,
                   "the request has " + std::to_string(goals) +
                       " goals: give exactly one of named_state, joint_goal and tool_goals");
  if (!message.named_state.empty()) {
    request->goal = arm::NamedState{message.named_state};
  } else if (!message.joint_goal.name.empty()) {
    const auto positions = ros_convert::to_positions(message.joint_goal);
    if (!positions) return failure(ArmCode::kInvalidRequest, "joint_goal: " + positions.error().message);
    request->goal = *positions;
  } else {
    std::vector<arm::ToolTarget> targets;
    for (const auto& goal : message.tool_goals) {
      auto target = to_target(goal, transforms);
      if (!target) return tl::unexpected(target.error());
      targets.push_back(std::move(*target));
    }
    request->goal = std::move(targets);
  }
  return {};
}

tl::expected<arm::ToolConstraint, Status> to_constraint(const extperfc::ToolConstraint& message,
                                                        const arm::ArmGroup& group,
                                                        const TransformLookup& transforms) {
  arm::ToolConstraint constraint;
  if (message.kind > extperfc::ToolConstraint::KEEP_RELATIVE)
    return failure(ArmCode::kInvalidRequest, "unknown kind of constraint " + std::to_string(message.kind));
  constraint.kind = static_cast<arm::ToolConstraintKind>(message.kind);
  constraint.link = message.link.empty() && group.tips.size() == 1 ? group.tips.front() : message.link;
  constraint.other_link = message.other_link;
  constraint.axis = {message.axis.x, message.axis.y, message.axis.z};
  if (message.kind != extperfc::ToolConstraint::KEEP_PLANE &&
      message.kind != extperfc::ToolConstraint::KEEP_LINE)
    return constraint;
  const auto root_T_frame = transforms.root_T_frame(message.frame_id, ros::Time());
  if (!root_T_frame) return tl::unexpected(root_T_frame.error());
  constraint.axis = root_T_frame->linear() * constraint.axis;
  return constraint;
}

}  // namespace

tl::expected<arm::JointPositions, Status> PlanExecution::read_start(
    const sensor_msgs::JointState& message) const {
  auto positions = shared_.robot_state.positions();
  if (!positions) return tl::unexpected(positions.error());
  const auto start = ros_convert::to_positions(message);
  if (!start) return failure(ArmCode::kInvalidRequest, "start: " + start.error().message);
  for (const auto& [name, value] : *start) {
    if (!shared_.arms.robot().joint(name))
      return failure(ArmCode::kInvalidRequest, "start: the robot has no joint '" + name + "'");
    (*positions)[name] = value;
  }
  return *std::move(positions);
}

tl::expected<MotionRequest, Status> PlanExecution::read(const ArmRequest& message) const {
  MotionRequest request;
  request.group = message.group;
  auto start = read_start(message.start);
  if (!start) return tl::unexpected(start.error());
  request.start = std::move(*start);
  if (auto done = read_goal(message, shared_.transforms, &request); !done)
    return tl::unexpected(done.error());
  if (message.motion > ArmRequest::LINEAR)
    return failure(ArmCode::kInvalidRequest, "unknown motion " + std::to_string(message.motion));
  request.kind = message.motion == ArmRequest::LINEAR ? arm::MotionKind::kLinear : arm::MotionKind::kFree;
  if (const auto group = shared_.arms.group(message.group))
    for (const auto& one : message.constraints) {
      auto constraint = to_constraint(one, **group, shared_.transforms);
      if (!constraint) return tl::unexpected(constraint.error());
      request.constraints.push_back(std::move(*constraint));
    }
  const auto& params = shared_.params;
  request.planning_time_s = value_or_default(message.planning_time, params.planning_time_s);
  request.velocity_scale = value_or_default(message.velocity_scale, params.velocity_scale);
  request.acceleration_scale = value_or_default(message.acceleration_scale, params.acceleration_scale);
  request.minimum_fraction = value_or_default(message.minimum_fraction, 1.0);
  request.improve = message.improve != 0;
  request.planner = message.planner;
  if (message.seed != 0) request.seed = message.seed;
  return request;
}

MotionOutcome PlanExecution::plan(const MotionRequest& request, const MotionCallbacks& callbacks) {
  const auto deadline = std::chrono::steady_clock::now() + kClearing;
  while (true) {
    auto world = shared_.scene.world();
    if (!world) {
      MotionOutcome outcome;
      outcome.code = world.error().code;
      outcome.message = world.error().message;
      return outcome;
    }
    if (callbacks.allow) callbacks.allow(*world);
    auto outcome = pipeline_.plan(request, *world);
    const bool may_clear =
        outcome.code == ArmCode::kStartInCollision && world->objects().count(PlanningScene::kSeenName) > 0;
    if (!may_clear || callbacks.cancel.cancelled() || std::chrono::steady_clock::now() >= deadline)
      return outcome;
    std::this_thread::sleep_for(kClearingStep);
  }
}

Moved PlanExecution::move(MotionRequest request, std::uint32_t replans, const MotionCallbacks& callbacks) {
  Moved moved;
  std::optional<Status> stopped;
  request.cancelled = [&] {
    if (!stopped) stopped = callbacks.cancel.reason();
    return stopped.has_value();
  };
  for (;; ++moved.replans) {
    if (callbacks.progress) callbacks.progress("planning", 0.0);
    if (const auto not_ready = shared_.robot_state.not_ready_reason())
      return moved.status = *not_ready, moved;
    const auto outcome = plan(request, callbacks);
    moved.status = stopped ? *stopped : Status{outcome.code, outcome.message};
    moved.fraction = outcome.fraction;
    if (outcome.code != ArmCode::kSuccess) return moved;
    moved.trajectory = ros_convert::to_message(outcome.joints, outcome.points);
    const auto path = arm::TimedPath::make(outcome.joints, outcome.points);
    if (!path) return moved.status = {ArmCode::kInternal, path.error().message}, moved;
    if (callbacks.planned) callbacks.planned(moved.trajectory);
    const auto execution = shared_.executor.run(*path, pipeline_, callbacks);
    moved.executed = execution.executed;
    if (execution.status.code == ArmCode::kSuccess) return moved;
    moved.status = execution.status;
    if (execution.status.code != ArmCode::kPathBlocked || moved.replans == replans) return moved;
    const auto positions = shared_.robot_state.positions();
    if (!positions) return moved.status = positions.error(), moved;
    request.start = *positions;
  }
}

Moved PlanExecution::execute(const trajectory_msgs::JointTrajectory& trajectory,
                             const MotionCallbacks& callbacks) {
  Moved moved;
  moved.trajectory = trajectory;
  moved.fraction = 1.0;
  const auto path = ros_convert::to_path(trajectory);
  if (!path) return moved.status = {ArmCode::kInvalidRequest, path.error().message}, moved;
  if (callbacks.planned) callbacks.planned(moved.trajectory);
  const auto execution = shared_.executor.run(*path, pipeline_, callbacks);
  moved.status = execution.status;
  moved.executed = execution.executed;
  return moved;
}

}  // namespace extperfc::ros_arm
