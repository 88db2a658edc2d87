#include "ros/robot/arm_motion.hpp"

#include <utility>
#include <vector>

#include "ros/robot/names.hpp"

namespace extperfc::ros_robot {

using simulate::TrajectoryCode;
using simulate::TrajectoryEnd;

namespace {

std::vector<simulate::FollowedJoint> followed_joints(const RobotModel& robot, simulate::Side side) {
  std::vector<simulate::FollowedJoint> joints;
  for (int i = 0; i < simulate::kArmJoints; ++i) {
    simulate::FollowedJoint joint{joint_name(side, i)};
    if (const auto index = robot.joint(joint.name)) {
      joint.lower = robot.joints()[*index].lower;
      joint.upper = robot.joints()[*index].upper;
    }
    joints.push_back(std::move(joint));
  }
  return joints;
}

simulate::JointMotion measure(const simulate::ArmState& state) {
  using Values = Eigen::Matrix<double, simulate::kArmJoints, 1>;
  return {Eigen::Map<const Values>(state.position.data()), Eigen::Map<const Values>(state.velocity.data()),
          Values::Zero()};
}

/// Why the arms do not move, with the remedy; empty when they do.
std::string reason_for_rest(const simulate::RobotState& state) {
  if (state.stopped) return "the robot is stopped: publish on robot/set_super_reset, then enable it";
  if (!state.enabled) return "the robot is disabled: publish true on robot/set_super_enable";
  return "";
}

}  // namespace

ArmMotion::ArmMotion(ros_simulate::SimHost& host, simulate::Side side,
                     const simulate::TrajectoryFollowerParams& params)
    : host_(host), side_(side), params_(params) {}

simulate::TrajectoryResult<void> ArmMotion::start(const simulate::Simulator& simulator,
                                                  const simulate::TrajectoryGoal& goal, WhenDone when_done) {
  const auto refuse = [](std::string why) {
    return tl::unexpected<TrajectoryEnd>(TrajectoryEnd{TrajectoryCode::kInvalidGoal, std::move(why)});
  };
  if (auto reason = reason_for_rest(simulator.robot_state()); !reason.empty()) return refuse(reason);
  if (!now_s_) return refuse("the simulation has not begun: let it run");
  if (!follower_) follower_.emplace(followed_joints(simulator.robot(), side_), params_);
  auto started = follower_->start(goal, *now_s_, measure(simulator.arm_state(side_)));
  if (!started) return started;
  finish(Status::kReplaced, {TrajectoryCode::kGoalToleranceViolated, "a newer motion took the arm"});
  when_done_ = std::move(when_done);
  return {};
}

void ArmMotion::stop() {
  if (follower_ && now_s_) follower_->stop(*now_s_);
}

void ArmMotion::yield_arm(const std::string& reason) {
  if (follower_) follower_->drop();
  finish(Status::kFailed, {TrajectoryCode::kPathToleranceViolated, reason});
}

void ArmMotion::after_step(const simulate::Simulator& simulator, const ros::Time& stamp) {
  now_s_ = stamp.toSec();
  if (!follower_ || !follower_->moving()) return;
  if (const auto reason = reason_for_rest(simulator.robot_state()); !reason.empty())
    return yield_arm("aborted: " + reason);
  const bool had_goal = follower_->following();
  const auto end = follower_->update(*now_s_, measure(simulator.arm_state(side_)));
  if (follower_->moving()) post_set_point(*now_s_ + simulator.params().bodies.step_s);
  if (end)
    finish(end->code == TrajectoryCode::kSuccessful ? Status::kReached : Status::kFailed, *end);
  else if (!had_goal && !follower_->moving())
    finish(Status::kStopped, {TrajectoryCode::kGoalToleranceViolated, "cancelled during the motion"});
}

void ArmMotion::finish(Status status, const TrajectoryEnd& end) {
  if (const auto when_done = std::exchange(when_done_, nullptr)) when_done(status, end);
}

void ArmMotion::post_set_point(double time_s) {
  simulate::ArmCommand command;
  command.mode = simulate::ArmMode::kRawPosition;
  const auto desired = follower_->desired(time_s);
  for (int i = 0; i < simulate::kArmJoints; ++i) command.values[i] = desired.position[i];
  // Without room for it the arm holds the set point before: the next one comes with the next step.
  (void)host_.post([this, command](simulate::Simulator& simulator) {
    if (!follower_->moving()) return;             // something took the arm meanwhile
    (void)simulator.command_arm(side_, command);  // finite and not in torque mode: cannot fail
  });
}

}  // namespace extperfc::ros_robot
