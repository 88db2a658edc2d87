#include "ros/arm/executor.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "ros/convert/arm.hpp"

namespace extperfc::ros_arm {

using actionlib::SimpleClientGoalState;
using arm::ArmCode;
using arm::JointPositions;
using arm::JointVector;
using arm::TimedPath;
using control_msgs::FollowJointTrajectoryResult;

namespace {

constexpr double kContactSearch = 1.0;  ///< after the end of the free part, to name the contact [s]
constexpr double kContactStep = 0.02;   ///< [s]
constexpr double kMoved = 0.01;         ///< of a joint that stands: the remaining path is checked again [rad]

/// The group whose joints are the path's, in any order.
const arm::ArmGroup* group_of(const arm::RobotArms& arms, const TimedPath& path) {
  const std::set<std::string> joints(path.joints().begin(), path.joints().end());
  for (const auto& group : arms.groups())
    if (std::set<std::string>(group.joints.begin(), group.joints.end()) == joints) return &group;
  return nullptr;
}

Status status_of(const std::string& action, const FollowJointTrajectoryResult* result,
                 const std::string& text) {
  const std::string why = result != nullptr && !result->error_string.empty() ? result->error_string : text;
  const bool tolerance =
      result != nullptr && (result->error_code == FollowJointTrajectoryResult::PATH_TOLERANCE_VIOLATED ||
                            result->error_code == FollowJointTrajectoryResult::GOAL_TOLERANCE_VIOLATED);
  return {tolerance ? ArmCode::kNotFollowing : ArmCode::kControllerRefused, action + ": " + why};
}

}  // namespace

Executor::Executor(const ros::NodeHandle& handle, const arm::RobotArms& arms,
                   const RobotStateMonitor& robot_state, const PlanningScene& scene,
                   const ros_params::ExecutionParams& params,
                   const std::vector<ros_params::ControllerParams>& controllers)
    : arms_(arms), robot_state_(robot_state), scene_(scene), params_(params) {
  ros::NodeHandle own(handle);  // the client wants to change it
  for (const auto& one : controllers)
    controllers_.push_back({one.action, one.group, std::make_unique<Client>(own, one.action, false)});
}

Result<void> Executor::check() const {
  for (const auto& controller : controllers_)
    if (auto group = arms_.group(controller.group); !group)
      return fail(ErrorCode::kInvalidArgument,
                  "controller " + controller.action + ": " + group.error().message);
  return {};
}

tl::expected<std::vector<Executor::Controller*>, Status> Executor::controllers_of(const TimedPath& path) {
  std::set<std::string> left(path.joints().begin(), path.joints().end());
  std::vector<Controller*> chosen;
  for (auto& controller : controllers_) {
    const auto& joints = (*arms_.group(controller.group))->joints;
    if (!std::all_of(joints.begin(), joints.end(), [&](const auto& joint) { return left.count(joint) > 0; }))
      continue;
    for (const auto& joint : joints) left.erase(joint);
    chosen.push_back(&controller);
  }
  if (!left.empty())
    return failure(ArmCode::kControllerMissing,
                   "no trajectory server controls " + *left.begin() + ": see the parameter controllers");
  return chosen;
}

tl::expected<void, Status> Executor::connect(const Controller& controller) const {
  const auto until = ros::WallTime::now() + ros::WallDuration(params_.connect_timeout_s);
  while (!controller.client->isServerConnected()) {
    if (ros::WallTime::now() > until || !ros::ok())
      return failure(ArmCode::kControllerMissing,
                     "no trajectory server at " + controller.action + ": is the robot's driver running?");
    ros::WallDuration(0.02).sleep();
  }
  return {};
}

/// One motion of the executor.
class Executor::Motion {
 public:
  Motion(Executor& executor, const arm::ArmGroup& group, TimedPath path, arm::MotionPipeline& pipeline,
         const MotionCallbacks& callbacks)
      : executor_(executor),
        group_(group),
        path_(std::move(path)),
        pipeline_(pipeline),
        callbacks_(callbacks) {}

  Execution run(const std::vector<Controller*>& controllers) {
    controllers_ = controllers;
    if (const auto wrong = look_first()) return {*wrong, 0.0};
    for (auto* controller : controllers_)
      if (auto connected = executor_.connect(*controller); !connected) return {connected.error(), 0.0};
    send_goals();
    const auto status = monitor();
    if (status.code != ArmCode::kSuccess) stop();
    return {status, status.code == ArmCode::kSuccess ? 1.0 : executed_};
  }

 private:
  /// See Executor. `started_` is that start by our own clock.
  void send_goals() {
    const bool together = controllers_.size() > 1;
    const ros::Duration delay(together ? executor_.params_.start_delay_s : 0.0);
    const ros::Time stamp = together ? executor_.robot_state_.robot_time() + delay : ros::Time();
    started_ = ros::Time::now() + delay;
    for (auto* controller : controllers_) {
      control_msgs::FollowJointTrajectoryGoal goal;
      const auto part = path_.only((*executor_.arms_.group(controller->group))->joints);
      goal.trajectory = ros_convert::to_message(part->joints(), part->points());
      goal.trajectory.header.stamp = stamp;
      controller->client->sendGoal(goal);
    }
  }

  [[nodiscard]] double elapsed() const { return std::max(0.0, (ros::Time::now() - started_).toSec()); }

  /// Whether it may begin.
  std::optional<Status> look_first() {
    if (auto not_ready = executor_.robot_state_.not_ready_reason()) return not_ready;
    const auto positions = executor_.robot_state_.positions();
    if (!positions) return positions.error();
    const auto measured = arm::RobotArms::select(group_, *positions);
    if (!measured) return Status{ArmCode::kNoJointStates, measured.error().message};
    Eigen::Index worst = 0;
    const double away = (path_.position(0.0) - *measured).cwiseAbs().maxCoeff(&worst);
    if (away > executor_.params_.start_tolerance_rad)
      return Status{ArmCode::kStartMoved, "the robot is not at the start of the trajectory: " +
                                              group_.joints[static_cast<std::size_t>(worst)] + " is " +
                                              std::to_string(away) + " rad away from it"};
    return check_remaining_path(*positions, 0.0);
  }

  Status monitor() {
    const ros::WallDuration period(1.0 / executor_.params_.monitor_rate_hz);
    for (;;) {
      period.sleep();
      const double now = elapsed();
      executed_ = std::clamp(now / std::max(path_.duration_s(), 1e-9), 0.0, 1.0);
      if (callbacks_.progress) callbacks_.progress("executing", executed_);
      if (const auto done = finished()) return *done;
      if (!ros::ok()) return {ArmCode::kCancelled, "the node shuts down"};
      if (const auto reason = callbacks_.cancel.reason()) return *reason;
      if (const auto not_ready = executor_.robot_state_.not_ready_reason()) return *not_ready;
      const auto positions = executor_.robot_state_.positions();
      if (!positions) return positions.error();
      if (const auto lost = following(*positions, now)) return *lost;
      if (const auto blocked = check_remaining_path(*positions, now)) return *blocked;
      if (now > path_.duration_s() + executor_.params_.finish_time_s)
        return {ArmCode::kControllerMissing, "the trajectory server does not report that it has finished"};
    }
  }

  std::optional<Status> finished() {
    bool all = true;
    for (auto* controller : controllers_) {
      const auto state = controller->client->getState();
      all = all && state == SimpleClientGoalState::SUCCEEDED;
      if (!state.isDone() || state == SimpleClientGoalState::SUCCEEDED) continue;
      // What ended the motion may be known from the robot's state a little later.
      for (int i = 0; i < 15 && !executor_.robot_state_.not_ready_reason(); ++i)
        ros::WallDuration(0.02).sleep();
      if (auto not_ready = executor_.robot_state_.not_ready_reason()) return not_ready;
      return status_of(
          controller->action, controller->client->getResult().get(),
          state == SimpleClientGoalState::LOST ? "the server lost the goal" : "ended as " + state.toString());
    }
    if (!all) return std::nullopt;
    return Status{ArmCode::kSuccess, ""};
  }

  std::optional<Status> following(const JointPositions& positions, double now) const {
    const auto measured = arm::RobotArms::select(group_, positions);
    if (!measured) return Status{ArmCode::kNoJointStates, measured.error().message};
    const double away = path_.deviation(*measured, now - executor_.params_.follow_delay_s, now + 0.1);
    if (away <= executor_.params_.follow_tolerance_rad) return std::nullopt;
    Eigen::Index worst = 0;
    (path_.position(now) - *measured).cwiseAbs().maxCoeff(&worst);
    return Status{ArmCode::kNotFollowing, group_.joints[static_cast<std::size_t>(worst)] +
                                              " does not follow the trajectory: deviation " +
                                              std::to_string(away) + " rad"};
  }

  [[nodiscard]] bool others_moved(const JointPositions& positions) const {
    for (const auto& [name, value] : checked_at_) {
      const auto now = positions.find(name);
      const bool ours = std::find(group_.joints.begin(), group_.joints.end(), name) != group_.joints.end();
      if (!ours && now != positions.end() && std::abs(now->second - value) > kMoved) return true;
    }
    return false;
  }

  /// Checks the remaining path when the scene or another joint changed.
  std::optional<Status> check_remaining_path(const JointPositions& positions, double now) {
    const auto version = executor_.scene_.version();
    if (version == seen_ && !others_moved(positions)) return std::nullopt;
    auto world = executor_.scene_.world();
    if (!world) return world.error();
    if (callbacks_.allow) callbacks_.allow(*world);
    auto checker = pipeline_.checker(group_.name, positions, *world, false);
    if (!checker) return Status{ArmCode::kInternal, checker.error().message};
    seen_ = version;
    checked_at_ = positions;
    const double free = path_.free_until(*checker, now);
    if (free >= path_.duration_s()) return std::nullopt;
    return Status{ArmCode::kPathBlocked,
                  "path blocked in " + std::to_string(free - now) + " s: " + why_blocked(*checker, free)};
  }

  /// The first contact after `free_s`, up to which the path is certified to be free.
  [[nodiscard]] std::string why_blocked(arm::CollisionChecker& checker, double free_s) const {
    const double end_s = std::min(free_s + kContactSearch, path_.duration_s());
    for (double at_s = free_s; at_s <= end_s; at_s += kContactStep)
      if (const auto contact = checker.contact(path_.position(at_s)))
        return contact->first + " would touch " + contact->second;
    return "clearance too small to certify the remaining path";
  }

  void stop() {
    if (callbacks_.progress) callbacks_.progress("stopping", executed_);
    for (auto* controller : controllers_)
      if (!controller->client->getState().isDone()) controller->client->cancelGoal();
    const auto until = ros::WallTime::now() + ros::WallDuration(executor_.params_.finish_time_s);
    for (auto* controller : controllers_)
      while (!controller->client->getState().isDone() && ros::WallTime::now() < until && ros::ok())
        ros::WallDuration(0.01).sleep();
  }

  Executor& executor_;
  const arm::ArmGroup& group_;
  const TimedPath path_;
  arm::MotionPipeline& pipeline_;
  const MotionCallbacks& callbacks_;
  std::vector<Controller*> controllers_;
  ros::Time started_;
  double executed_{0};
  std::optional<std::uint64_t> seen_;  ///< version of the scene
  JointPositions checked_at_;
};

Execution Executor::run(const TimedPath& path, arm::MotionPipeline& pipeline,
                        const MotionCallbacks& callbacks) {
  const auto* group = group_of(arms_, path);
  if (group == nullptr)
    return {{ArmCode::kInvalidRequest, "the trajectory's joints are not those of one of the robot's groups"},
            0.0};
  auto ordered = path.only(group->joints);
  if (!ordered) return {{ArmCode::kInvalidRequest, ordered.error().message}, 0.0};
  const auto controllers = controllers_of(*ordered);
  if (!controllers) return {controllers.error(), 0.0};
  return Motion(*this, *group, std::move(*ordered), pipeline, callbacks).run(*controllers);
}

}  // namespace extperfc::ros_arm
