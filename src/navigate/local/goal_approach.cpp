#include "navigate/local/goal_approach.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/base/math.hpp"

#include "navigate/local/path_window.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kNear_m = 0.45;
constexpr double kGain_per_s = 1.6;         // stable for delays up to 0.6 s, no overshoot up to 0.2 s
constexpr double kApproachPart = 0.5;       // of the accelerations
constexpr double kInside = 0.5;             // part of the tolerance in which the base stops
constexpr double kFinalSlowest_m_s = 0.04;  // gets there in a finite time
constexpr double kSlowest_rad_s = 0.08;     // the same
constexpr double kSameGoal_m = 0.3;
constexpr double kSameGoal_rad = 0.3;

double falling(double error, double acceleration, double slowest) {
  return std::max(slowest,
                  std::min(kGain_per_s * error, std::sqrt(2 * kApproachPart * acceleration * error)));
}

}  // namespace

bool GoalApproach::set_goal(const Pose2& goal, const GoalTolerance& tolerance) {
  const Pose2 change = between(goal_, goal);
  const bool same = std::hypot(change.x, change.y) < kSameGoal_m && std::abs(change.yaw) < kSameGoal_rad;
  if (!same) phase_ = Phase::kApproach;
  goal_ = goal;
  tolerance_ = tolerance;
  return same;
}

bool GoalApproach::near(const Pose2& pose, double remaining_m) const {
  const Pose2 error = between(pose, goal_);
  const double distance_m = std::hypot(error.x, error.y);
  // Straight to the goal is off the path's curve, which a differential base needs to arrive with its heading.
  const double near_m = base_ == BaseKind::kHolonomic ? kNear_m : 1.5 * tolerance_.xy_m;
  return distance_m < near_m && remaining_m < 1.5 * kNear_m + kRadian_m * kPi;
}

bool GoalApproach::within(const Pose2& pose) const {
  const Pose2 error = between(pose, goal_);
  return std::hypot(error.x, error.y) <= tolerance_.xy_m && std::abs(error.yaw) <= tolerance_.yaw_rad;
}

double GoalApproach::speed(double distance_m) const {
  return falling(distance_m, std::min(limits_.acc_x_m_s2, limits_.acc_y_m_s2), kFinalSlowest_m_s);
}

double GoalApproach::rotation(double error_rad) const {
  return std::copysign(falling(std::abs(error_rad), limits_.acc_wz_rad_s2, kSlowest_rad_s), error_rad);
}

Twist2 GoalApproach::velocity(const Pose2& pose) {
  const Pose2 error = between(pose, goal_);
  choose_phase(error);
  if (phase_ == Phase::kSettled) return {};
  return base_ == BaseKind::kHolonomic ? holonomic(error) : differential(error);
}

void GoalApproach::choose_phase(const Pose2& error) {
  const double distance_m = std::hypot(error.x, error.y);
  const double off_rad = std::abs(error.yaw);
  const bool there = distance_m < kInside * tolerance_.xy_m;
  const bool aligned = off_rad < kInside * tolerance_.yaw_rad;
  switch (phase_) {
    case Phase::kSettled:
      if (distance_m > tolerance_.xy_m)
        phase_ = Phase::kApproach;
      else if (off_rad > tolerance_.yaw_rad)
        phase_ = Phase::kRotate;
      return;
    case Phase::kRotate:
      if (distance_m > tolerance_.xy_m)
        phase_ = Phase::kApproach;
      else if (aligned)
        phase_ = Phase::kSettled;
      return;
    case Phase::kApproach: {
      // A differential base that has the goal beside it would have to rotate twice for a few centimetres.
      const bool beside = base_ == BaseKind::kDifferential && distance_m < 0.9 * tolerance_.xy_m &&
                          std::abs(error.y) > std::abs(error.x);
      if (there && aligned)
        phase_ = Phase::kSettled;
      else if (there || beside)
        phase_ = Phase::kRotate;
    }
  }
}

Twist2 GoalApproach::holonomic(const Pose2& error) const {
  const double distance_m = std::hypot(error.x, error.y);
  const bool moves = phase_ == Phase::kApproach && distance_m > 0;
  const bool rotates = std::abs(error.yaw) > kInside * tolerance_.yaw_rad;
  const double per_m = moves ? speed(distance_m) / distance_m : 0;
  return {per_m * error.x, per_m * error.y, rotates ? rotation(error.yaw) : 0};
}

Twist2 GoalApproach::differential(const Pose2& error) const {
  if (phase_ == Phase::kRotate) return {0, 0, rotation(error.yaw)};
  const double distance_m = std::hypot(error.x, error.y);
  const bool backwards = error.x < 0 && limits_.min_vx_m_s < 0;
  const double bearing = backwards ? std::atan2(-error.y, -error.x) : std::atan2(error.y, error.x);
  const double along = std::max(0.0, std::cos(bearing) - 0.5) * 2 * speed(distance_m);
  return {backwards ? -along : along, 0, 2 * bearing};
}

}  // namespace extperfc::navigate
