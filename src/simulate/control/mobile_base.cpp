#include "simulate/control/mobile_base.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::simulate {
namespace {

constexpr double kWheelRadius = 0.1016;                     // [m]
constexpr double kHalfReach = 0.5 * (0.680466 + 0.505466);  // half track plus half wheelbase [m]

double towards(double value, double goal, double change) {
  return std::clamp(goal, value - change, value + change);
}

}  // namespace

std::array<double, 4> wheel_speeds(const Twist2& t) {
  const double rotation = kHalfReach * t.wz;
  return {(t.vx - t.vy - rotation) / kWheelRadius, (t.vx + t.vy + rotation) / kWheelRadius,
          (t.vx + t.vy - rotation) / kWheelRadius, (t.vx - t.vy + rotation) / kWheelRadius};
}

Twist2 twist_of(const std::array<double, 4>& w) {
  constexpr double kQuarter = kWheelRadius / 4;
  return {kQuarter * (w[0] + w[1] + w[2] + w[3]), kQuarter * (-w[0] + w[1] + w[2] - w[3]),
          kQuarter * (-w[0] + w[1] - w[2] + w[3]) / kHalfReach};
}

double Wander::step(Rng& rng, double step_s) {
  constexpr double kCorrelationS = 0.5;
  const double kept = std::exp(-step_s / kCorrelationS);
  value_ = kept * value_ + sigma_ * std::sqrt(1 - kept * kept) * rng.normal(0, 1);
  return value_;
}

MobileBase::MobileBase(const BaseParams& params, const Pose2& start, std::uint64_t seed)
    : params_(params), rng_(seed) {
  state_.truth = start;
  slip_.fill(Wander(params_.wheel_slip));
  encoder_error_.fill(Wander(params_.wheel_noise));
  gyro_bias_ = rng_.normal(0, params_.gyro_bias_rad_s);
}

void MobileBase::command(const Twist2& velocity, double now_s) {
  if (!is_finite(velocity)) return;
  // The direction is kept: a vector that is too long is shortened as a whole.
  const double longest = std::max({1.0, std::hypot(velocity.vx, velocity.vy) / params_.max_speed_m_s,
                                   std::abs(velocity.wz) / params_.max_yaw_rate_rad_s});
  wanted_ = {velocity.vx / longest, velocity.vy / longest, velocity.wz / longest};
  command_time_s_ = now_s;
}

void MobileBase::place(const Pose2& pose) {
  state_.truth = pose;
  state_.velocity = state_.measured = drive_ = wanted_ = Twist2{};
  state_.wheel_velocity = {};
}

Twist2 MobileBase::limited_command(double now_s, double step_s) const {
  const bool fresh = now_s - command_time_s_ < params_.command_timeout_s;
  const Twist2 goal = fresh ? wanted_ : Twist2{};
  const double change = params_.max_accel_m_s2 * step_s;
  return {towards(drive_.vx, goal.vx, change), towards(drive_.vy, goal.vy, change),
          towards(drive_.wz, goal.wz, params_.max_yaw_accel_rad_s2 * step_s)};
}

Twist2 MobileBase::with_slip(const std::array<double, 4>& wheels, double step_s) {
  std::array<double, 4> effective{};
  for (int i = 0; i < 4; ++i) {
    effective[i] = wheels[i] * (1 - slip_[i].step(rng_, step_s)) * (1 - fault_slip_[i]);
  }
  Twist2 twist = twist_of(effective);
  twist.vy *= 1 - params_.lateral_slip;
  return twist;
}

void MobileBase::measure(const std::array<double, 4>& wheels, double step_s) {
  std::array<double, 4> measured{};
  for (int i = 0; i < 4; ++i) {
    measured[i] = wheels[i] * (1 + encoder_error_[i].step(rng_, step_s));
    state_.wheel_velocity[i] = measured[i];
    state_.wheel_position[i] += measured[i] * step_s;
  }
  state_.measured = twist_of(measured);
  state_.odometry = advance(state_.odometry, state_.measured, step_s);
}

void MobileBase::sense(const Twist2& before, double step_s) {
  const Twist2& now = state_.velocity;
  const auto noise = [this] { return rng_.normal(0, params_.accel_noise_m_s2); };
  // d(v)/dt + w x v in the base's frame, and what carries it against gravity.
  const double ax = (now.vx - before.vx) / step_s - now.wz * now.vy;
  const double ay = (now.vy - before.vy) / step_s + now.wz * now.vx;
  imu_.acceleration = {ax + noise(), ay + noise(), 9.81 + noise()};
  imu_.angular_velocity = {rng_.normal(0, params_.gyro_noise_rad_s), rng_.normal(0, params_.gyro_noise_rad_s),
                           now.wz + gyro_bias_ + rng_.normal(0, params_.gyro_noise_rad_s)};
  imu_.yaw = wrap_angle(imu_.yaw + imu_.angular_velocity.z() * step_s);
}

void MobileBase::step(double now_s, double step_s, const std::function<bool(const Pose2&)>& collides) {
  const Twist2 before = state_.velocity;
  drive_ = limited_command(now_s, step_s);
  const auto wheels = wheel_speeds(drive_);
  const Twist2 motion = with_slip(wheels, step_s);
  const bool moves = std::abs(motion.vx) + std::abs(motion.vy) + std::abs(motion.wz) > 0;
  const Pose2 next = advance(state_.truth, motion, step_s);
  // Where something overlaps the base already (a person who walked into it), it may drive away.
  state_.blocked = moves && collides(next) && !collides(state_.truth);
  if (moves && !state_.blocked) state_.truth = next;
  state_.velocity = state_.blocked ? Twist2{} : motion;
  measure(wheels, step_s);
  sense(before, step_s);
}

}  // namespace extperfc::simulate
