#include "extperfc/simulate/trajectory_follower.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "simulate/trajectory/goal_check.hpp"

namespace extperfc::simulate {

namespace {

/// `from`, each joint slowed down to rest.
JointMotion braked(const JointMotion& from, double elapsed_s, double deceleration) {
  const auto n = from.position.size();
  JointMotion motion{from.position, Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const double speed = from.velocity[i];
    const double moving_s = std::min(std::max(elapsed_s, 0.0), std::abs(speed) / deceleration);
    const double slowing = std::copysign(deceleration, -speed);
    motion.position[i] += speed * moving_s + 0.5 * slowing * moving_s * moving_s;
    if (elapsed_s < std::abs(speed) / deceleration) {
      motion.velocity[i] = speed + slowing * moving_s;
      motion.acceleration[i] = slowing;
    }
  }
  return motion;
}

/// Where the trajectory begins, in the form of the first of `knots`: without its velocities the first part
/// stays straight.
JointKnot knot_before(const JointKnot& next, double time_s, const JointMotion& motion) {
  JointKnot knot{time_s, motion.position, std::nullopt, std::nullopt};
  if (next.velocity) knot.velocity = motion.velocity;
  if (next.acceleration) knot.acceleration = motion.acceleration;
  return knot;
}

std::string text_of(const FollowedJoint& joint, const char* what, double error, double bound,
                    const char* unit) {
  return joint.name + " is " + to_text(std::abs(error)) + " " + unit + " off its " + what + " (tolerance " +
         to_text(bound) + ")";
}

}  // namespace

TrajectoryFollower::TrajectoryFollower(std::vector<FollowedJoint> joints,
                                       const TrajectoryFollowerParams& params)
    : joints_(std::move(joints)), params_(params) {}

TrajectoryResult<void> TrajectoryFollower::start(const TrajectoryGoal& goal, double now_s,
                                                 const JointMotion& measured) {
  auto checked = check_goal(goal, joints_, params_, now_s);
  if (!checked) return tl::unexpected(checked.error());
  const auto rest = Eigen::VectorXd::Zero(measured.position.size());
  const JointMotion from =
      moving() ? desired(now_s) : JointMotion{measured.position, measured.velocity, rest};
  brake_from(now_s, from);
  const double begin_s = std::max(now_s, checked->start_s);
  auto& knots = checked->knots;
  if (knots.front().time_s > begin_s) {
    const auto motion =
        begin_s > now_s ? braked(from, begin_s - now_s, params_.stop_deceleration_rad_s2) : from;
    knots.insert(knots.begin(), knot_before(knots.front(), begin_s, motion));
  }
  spline_ = JointSpline(knots);
  start_s_ = begin_s;
  goal_time_s_ = checked->goal_time_s;
  path_bounds_ = std::move(checked->path_bounds);
  goal_bounds_ = std::move(checked->goal_bounds);
  measure(now_s, measured);
  begun_ = false;
  phase_ = Phase::kFollowing;
  return {};
}

void TrajectoryFollower::stop(double now_s) {
  if (phase_ != Phase::kFollowing) return;
  brake_from(now_s, desired(now_s));
  phase_ = Phase::kStopping;
}

void TrajectoryFollower::drop() {
  phase_ = Phase::kIdle;
}

std::optional<TrajectoryEnd> TrajectoryFollower::update(double now_s, const JointMotion& measured) {
  const bool clock_went_back = last_update_s_ && now_s < *last_update_s_;
  measure(now_s, measured);
  if (phase_ == Phase::kIdle) return std::nullopt;
  if (clock_went_back) {
    const bool had_goal = following();
    drop();
    if (!had_goal) return std::nullopt;
    return TrajectoryEnd{TrajectoryCode::kPathToleranceViolated, "the clock went back during the motion"};
  }
  if (phase_ == Phase::kStopping) {
    if (desired(now_s).velocity.isZero(0)) drop();
    return std::nullopt;
  }
  if (now_s < start_s_) return std::nullopt;
  const bool before_end = !begun_ || now_s <= spline_.end_s();
  begun_ = true;
  auto end = before_end ? judge_path(now_s) : judge_goal(now_s);
  if (!end) return std::nullopt;
  if (end->code == TrajectoryCode::kSuccessful) {
    drop();
  } else {
    brake_from(now_s, measured_);
    phase_ = Phase::kStopping;
  }
  return end;
}

JointMotion TrajectoryFollower::desired(double time_s) const {
  if (phase_ == Phase::kFollowing && time_s >= start_s_) return spline_.sample(time_s);
  return braked(brake_, time_s - brake_start_s_, params_.stop_deceleration_rad_s2);
}

void TrajectoryFollower::measure(double now_s, const JointMotion& measured) {
  const double passed_s = last_update_s_ ? now_s - *last_update_s_ : 0.0;
  JointMotion motion{measured.position, measured.velocity, Eigen::VectorXd::Zero(measured.velocity.size())};
  if (passed_s > 0) {
    motion.acceleration = (measured.velocity - measured_.velocity) / passed_s;
  } else if (passed_s == 0 && measured_.acceleration.size() == motion.acceleration.size()) {
    motion.acceleration = measured_.acceleration;
  }
  measured_ = std::move(motion);
  last_update_s_ = now_s;
}

void TrajectoryFollower::brake_from(double now_s, const JointMotion& motion) {
  brake_ = motion;
  brake_start_s_ = now_s;
}

std::optional<TrajectoryEnd> TrajectoryFollower::judge_path(double now_s) const {
  const auto violation = first_violation(desired(now_s), path_bounds_);
  if (violation.empty()) return std::nullopt;
  return TrajectoryEnd{TrajectoryCode::kPathToleranceViolated,
                       violation + " " + to_text(now_s - start_s_) + " s after the start"};
}

std::optional<TrajectoryEnd> TrajectoryFollower::judge_goal(double now_s) const {
  const auto violation = first_violation(spline_.sample(spline_.end_s()), goal_bounds_);
  if (violation.empty()) return TrajectoryEnd{TrajectoryCode::kSuccessful, ""};
  if (now_s <= spline_.end_s() + goal_time_s_) return std::nullopt;
  return TrajectoryEnd{TrajectoryCode::kGoalToleranceViolated,
                       violation + " " + to_text(goal_time_s_) + " s after the last point's time"};
}

std::string TrajectoryFollower::first_violation(const JointMotion& wanted, const MotionBounds& bounds) const {
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const auto index = static_cast<Eigen::Index>(i);
    const auto exceeds = [&](const auto& want, const auto& have, const auto& bound) {
      return std::abs(want[index] - have[index]) > bound[index];
    };
    const auto describe = [&](const char* what, const auto& want, const auto& have, const auto& bound,
                              const char* unit) {
      return text_of(joints_[i], what, want[index] - have[index], bound[index], unit);
    };
    if (exceeds(wanted.position, measured_.position, bounds.position))
      return describe("position", wanted.position, measured_.position, bounds.position, "rad");
    if (exceeds(wanted.velocity, measured_.velocity, bounds.velocity))
      return describe("velocity", wanted.velocity, measured_.velocity, bounds.velocity, "rad/s");
    if (exceeds(wanted.acceleration, measured_.acceleration, bounds.acceleration))
      return describe("acceleration", wanted.acceleration, measured_.acceleration, bounds.acceleration,
                      "rad/s^2");
  }
  return "";
}

}  // namespace extperfc::simulate
