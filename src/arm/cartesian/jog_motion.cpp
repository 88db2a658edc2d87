#include "arm/cartesian/jog_motion.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "arm/cartesian/newton.hpp"
#include "arm/kinematics/normal_equations.hpp"

namespace extperfc::arm {

namespace {

constexpr double kMinDamping = 1e-8;
constexpr double kProbeRad = 1e-3;  // how far ahead the smallest singular value is looked at
constexpr double kCentring = 0.5;   // [1/rad], fraction of the speed that may go into the null space
constexpr double kMinScale = 1e-3;  // below this a motion is at its end

double min_singular_value(const Jacobian& columns) {
  const Eigen::Matrix<double, 6, 6> square = columns * columns.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(square, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
}

// Grows steeply near the limits; at most about one.
JointVector away_from_limits(const JointLimits& limits, const JointVector& positions) {
  return from_mid_range(limits, positions).unaryExpr([](double x) {
    return -std::pow(std::clamp(x, -1.0, 1.0), 5);
  });
}

void slow(JogWish& wish, double scale, JogHindrance hindrance, int joint = -1) {
  if (scale >= 1) return;
  if (scale < kMinScale) scale = 0;
  wish.velocity *= scale;
  if (wish.hindrance == JogHindrance::kNone || scale < wish.scale) {
    wish.hindrance = hindrance;
    wish.joint = joint;
  }
  wish.scale *= scale;
}

}  // namespace

JogVelocity::JogVelocity(const ArmChain& chain, const JoggerParams& params)
    : chain_(chain),
      params_(params),
      max_velocity_(params.max_velocity.size() > 0 ? params.max_velocity : chain.max_velocity()) {
  const double brakes = 0.5 * max_velocity_.maxCoeff() / params_.max_acceleration_rad_s2 + params_.reaction_s;
  params_.limit_approach_s = std::max(params_.limit_approach_s, 1.1 * brakes);
}

JogWish JogVelocity::wish(const JogCommand& command, const JointVector& positions) const {
  JogWish wish;
  wish.velocity = JointVector::Zero(positions.size());
  if (command.kind == JogCommand::Kind::kStop) return wish;
  if (command.kind == JogCommand::Kind::kJoints)
    wish.velocity = command.joint_velocity;
  else
    follow_twist(command, positions, wish);
  const double excess = wish.velocity.cwiseAbs().cwiseQuotient(max_velocity_).maxCoeff();
  if (excess > 1) wish.velocity /= excess;
  slow_for_limits(positions, wish);
  return wish;
}

void JogVelocity::follow_twist(const JogCommand& command, const JointVector& positions, JogWish& wish) const {
  Eigen::Matrix<double, 6, 1> twist = command.twist;
  if (twist.isZero(0)) return;
  if (command.kind == JogCommand::Kind::kTwistTip) {
    const Eigen::Matrix3d rotation = chain_.forward(positions).linear();
    twist << rotation * command.twist.head<3>(), rotation * command.twist.tail<3>();
  }
  const Jacobian columns = chain_.jacobian(positions);
  const double singular_value = min_singular_value(columns);
  const double near = std::min(1.0, singular_value / params_.singularity_slow);
  const double damping =
      kMinDamping + (1 - near * near) * params_.singularity_stop * params_.singularity_stop;
  wish.velocity = min_norm_change(columns, twist, damping);
  const JointVector pull = kCentring * wish.velocity.norm() * away_from_limits(chain_.limits(), positions);
  const Vector6 moved = columns * pull;
  wish.velocity += pull - min_norm_change(columns, moved, damping);
  const double speed = wish.velocity.norm();
  if (near >= 1 || speed == 0) return;
  const JointVector ahead = positions + (kProbeRad / speed) * wish.velocity;
  if (min_singular_value(chain_.jacobian(ahead)) >= singular_value) return;  // on the way out
  slow(wish,
       std::max(0.0, (singular_value - params_.singularity_stop) /
                         (params_.singularity_slow - params_.singularity_stop)),
       JogHindrance::kSingularity);
}

void JogVelocity::slow_for_limits(const JointVector& positions, JogWish& wish) const {
  const auto& [lower, upper] = chain_.limits();
  double scale = 1;
  int joint = -1;
  for (int j = 0; j < positions.size(); ++j) {
    const double speed = wish.velocity[j];
    const double room = speed > 0 ? upper[j] - positions[j] : positions[j] - lower[j];
    const double max_speed = std::max(0.0, room) / params_.limit_approach_s;
    if (std::abs(speed) <= max_speed || max_speed >= scale * std::abs(speed)) continue;
    scale = max_speed / std::abs(speed);
    joint = j;
  }
  slow(wish, scale, JogHindrance::kJointLimit, joint);
}

JogMove JogBrakes::move(const JogState& now, const JointVector& velocity, double fraction,
                        double dt_s) const {
  const double stands_s = time_to_stand(now.velocities);
  const double braking_s = std::min(dt_s, stands_s);
  const JointVector braked = stands_s > dt_s ? JointVector((1 - dt_s / stands_s) * now.velocities)
                                             : JointVector(JointVector::Zero(now.velocities.size()));
  const JointVector braked_delta = 0.5 * braking_s * (now.velocities + braked);

  JointVector change = velocity - now.velocities;
  const double excess = change.cwiseAbs().maxCoeff() / (acceleration_ * dt_s);
  if (excess > 1) change /= excess;
  const JointVector reached = now.velocities + change;
  const JointVector delta = 0.5 * dt_s * (now.velocities + reached);

  JogMove move;
  move.next.velocities = braked + fraction * (reached - braked);
  move.next.positions = now.positions + braked_delta + fraction * (delta - braked_delta);
  const double after_s = time_to_stand(move.next.velocities);
  move.stand = move.next.positions + (0.5 * after_s + reaction_s_) * move.next.velocities;
  return move;
}

}  // namespace extperfc::arm
