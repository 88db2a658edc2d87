#include "ros/arm/commander.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "ros/convert/arm.hpp"

namespace extperfc::arm_node {

using arm::ArmCode;
using arm::MotionOutcome;
using arm::MotionRequest;
using extperfc::ArmRequest;
using extperfc::ToolGoal;

namespace {

constexpr double kExact = 1e-4;  // [m] or [rad], what 0 stands for

tl::expected<Eigen::Vector3d, Ending> tolerance(const geometry_msgs::Vector3& message, double free_from) {
  Eigen::Vector3d tolerance(message.x, message.y, message.z);
  for (auto& value : tolerance) {
    if (!(value >= 0.0))
      return end(ArmCode::kInvalidRequest, "a tolerance of the goal is negative or not a number");
    if (value == 0.0) value = kExact;
    if (value >= free_from) value = std::numeric_limits<double>::infinity();
  }
  return tolerance;
}

tl::expected<arm::ToolTarget, Ending> to_target(const ToolGoal& message, const FrameFinder& frames) {
  arm::ToolTarget target;
  target.link = message.link;
  const auto pose = frames.root_T_pose(message.pose);
  if (!pose) return tl::unexpected(pose.error());
  target.root_T_tool = *pose;
  const auto position = tolerance(message.position_tolerance, std::numeric_limits<double>::infinity());
  if (!position) return tl::unexpected(position.error());
  const auto orientation = tolerance(message.orientation_tolerance, M_PI);
  if (!orientation) return tl::unexpected(orientation.error());
  target.tolerance = {*position, *orientation};
  return target;
}

double or_else(double value, double instead) {
  return value == 0.0 ? instead : value;
}

tl::expected<void, Ending> read_goal(const ArmRequest& message, const FrameFinder& frames,
                                     MotionRequest* request) {
  const int goals = (message.named_state.empty() ? 0 : 1) + (message.joint_goal.name.empty() ? 0 : 1) +
                    (message.tool_goals.empty() ? 0 : 1);
  if (goals != 1)
    return end(ArmCode::kInvalidRequest, "the request has " + std::to_string(goals) +
                                             " goals: give one of named_state, joint_goal and tool_goals");
  if (!message.named_state.empty()) {
    request->goal = arm::NamedState{message.named_state};
  } else if (!message.joint_goal.name.empty()) {
    const auto positions = convert::to_positions(message.joint_goal);
    if (!positions) return end(ArmCode::kInvalidRequest, "joint_goal: " + positions.error().message);
    request->goal = *positions;
  } else {
    std::vector<arm::ToolTarget> targets;
    for (const auto& goal : message.tool_goals) {
      auto target = to_target(goal, frames);
      if (!target) return tl::unexpected(target.error());
      targets.push_back(std::move(*target));
    }
    request->goal = std::move(targets);
  }
  return {};
}

tl::expected<arm::ToolConstraint, Ending> to_constraint(const extperfc::ToolConstraint& message,
                                                        const arm::ArmGroup& group,
                                                        const FrameFinder& frames) {
  arm::ToolConstraint constraint;
  if (message.kind > extperfc::ToolConstraint::KEEP_RELATIVE)
    return end(ArmCode::kInvalidRequest,
               "a constraint of kind " + std::to_string(message.kind) + " is unknown");
  constraint.kind = static_cast<arm::ToolConstraintKind>(message.kind);
  constraint.link = message.link.empty() && group.tips.size() == 1 ? group.tips.front() : message.link;
  constraint.other_link = message.other_link;
  constraint.axis = {message.axis.x, message.axis.y, message.axis.z};
  if (message.kind != extperfc::ToolConstraint::KEEP_PLANE &&
      message.kind != extperfc::ToolConstraint::KEEP_LINE)
    return constraint;
  const auto root_T_frame = frames.root_T_frame(message.frame_id, ros::Time());
  if (!root_T_frame) return tl::unexpected(root_T_frame.error());
  constraint.axis = root_T_frame->linear() * constraint.axis;
  return constraint;
}

}  // namespace

tl::expected<MotionRequest, Ending> Commander::read(const ArmRequest& message) const {
  MotionRequest request;
  request.group = message.group;
  const auto positions = shared_.watch.positions();
  if (!positions) return tl::unexpected(positions.error());
  request.start = *positions;
  if (!message.start.name.empty()) {
    const auto start = convert::to_positions(message.start);
    if (!start) return end(ArmCode::kInvalidRequest, "start: " + start.error().message);
    for (const auto& [name, value] : *start) {
      if (!shared_.arms.robot().joint(name))
        return end(ArmCode::kInvalidRequest, "start: the robot has no joint '" + name + "'");
      request.start[name] = value;
    }
  }
  if (auto done = read_goal(message, shared_.frames, &request); !done) return tl::unexpected(done.error());
  if (message.motion > ArmRequest::LINEAR)
    return end(ArmCode::kInvalidRequest, "motion " + std::to_string(message.motion) + " is unknown");
  request.kind = message.motion == ArmRequest::LINEAR ? arm::MotionKind::kLinear : arm::MotionKind::kFree;
  if (const auto group = shared_.arms.group(message.group))
    for (const auto& one : message.constraints) {
      auto constraint = to_constraint(one, **group, shared_.frames);
      if (!constraint) return tl::unexpected(constraint.error());
      request.constraints.push_back(std::move(*constraint));
    }
  const auto& params = shared_.params;
  request.planning_time_s = or_else(message.planning_time, params.planning_time_s);
  request.velocity_scale = or_else(message.velocity_scale, params.velocity_scale);
  request.acceleration_scale = or_else(message.acceleration_scale, params.acceleration_scale);
  request.minimum_fraction = or_else(message.minimum_fraction, 1.0);
  request.improve = message.improve != 0;
  request.planner = message.planner;
  if (message.seed != 0) request.seed = message.seed;
  return request;
}

MotionOutcome Commander::plan(const MotionRequest& request, const Hooks& hooks) {
  MotionOutcome outcome;
  auto world = shared_.scene.world();
  if (world && hooks.allow) hooks.allow(*world);
  if (world) return pipeline_.plan(request, *world);
  outcome.code = world.error().code;
  outcome.message = world.error().message;
  return outcome;
}

Moved Commander::move(MotionRequest request, std::uint32_t replans, const Hooks& hooks) {
  Moved moved;
  std::optional<Ending> stopped;
  request.cancelled = [&] {
    if (!stopped && hooks.interrupted) stopped = hooks.interrupted();
    return stopped.has_value();
  };
  for (;; ++moved.replans) {
    if (hooks.progress) hooks.progress("planning", 0.0);
    if (const auto obstacle = shared_.watch.obstacle()) return moved.ending = *obstacle, moved;
    const auto outcome = plan(request, hooks);
    moved.ending = stopped ? *stopped : Ending{outcome.code, outcome.message};
    moved.fraction = outcome.fraction;
    if (outcome.code != ArmCode::kSuccess) return moved;
    moved.trajectory = convert::to_message(outcome.joints, outcome.points);
    const auto path = arm::TimedPath::make(outcome.joints, outcome.points);
    if (!path) return moved.ending = {ArmCode::kInternal, path.error().message}, moved;
    if (hooks.planned) hooks.planned(moved.trajectory);
    const auto execution = shared_.executor.run(*path, pipeline_, hooks);
    moved.executed = execution.executed;
    if (execution.ending.code == ArmCode::kSuccess) return moved;
    moved.ending = execution.ending;
    if (execution.ending.code != ArmCode::kPathBlocked || moved.replans == replans) return moved;
    const auto positions = shared_.watch.positions();
    if (!positions) return moved.ending = positions.error(), moved;
    request.start = *positions;
  }
}

Moved Commander::execute(const trajectory_msgs::JointTrajectory& trajectory, const Hooks& hooks) {
  Moved moved;
  moved.trajectory = trajectory;
  moved.fraction = 1.0;
  const auto path = convert::to_path(trajectory);
  if (!path) return moved.ending = {ArmCode::kInvalidRequest, path.error().message}, moved;
  if (hooks.planned) hooks.planned(moved.trajectory);
  const auto execution = shared_.executor.run(*path, pipeline_, hooks);
  moved.ending = execution.ending;
  moved.executed = execution.executed;
  return moved;
}

}  // namespace extperfc::arm_node
