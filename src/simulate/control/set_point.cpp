#include "simulate/control/set_point.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::simulate {

double braking_speed(double distance, double accel, double step_s) {
  // In units of a t^2 and a t: braking from speed k + f (k whole, 0 <= f < 1) covers (k + 1) (k / 2 + f).
  const double room = std::max(0.0, distance) / (accel * step_s * step_s);
  const double whole = std::floor((std::sqrt(8 * room + 1) - 1) / 2);
  return accel * step_s * (whole / 2 + room / (whole + 1));
}

void SetPoint::advance(double wanted_velocity, const MotionLimits& limits, double step_s) {
  const double change = limits.max_accel * step_s;
  velocity_ = std::clamp(wanted_velocity, velocity_ - change, velocity_ + change);
  const double next = std::clamp(position_ + velocity_ * step_s, limits.lower, limits.upper);
  velocity_ = (next - position_) / step_s;
  position_ = next;
}

void SetPoint::move_to(double goal, const MotionLimits& limits, double step_s) {
  goal = std::clamp(goal, limits.lower, limits.upper);
  const double distance = goal - position_;
  const double last_step = limits.max_accel * step_s;
  if (std::abs(distance) <= last_step * step_s && std::abs(velocity_) <= last_step) {
    hold(goal);
    return;
  }
  const double speed =
      std::min(limits.max_velocity, braking_speed(std::abs(distance), limits.max_accel, step_s));
  advance(std::copysign(speed, distance), limits, step_s);
}

void SetPoint::move_at(double wanted_velocity, const MotionLimits& limits, double step_s) {
  const double below = braking_speed(position_ - limits.lower, limits.max_accel, step_s);
  const double above = braking_speed(limits.upper - position_, limits.max_accel, step_s);
  const double speed = std::clamp(wanted_velocity, -limits.max_velocity, limits.max_velocity);
  advance(std::clamp(speed, -below, above), limits, step_s);
}

void SetPoint::follow(double goal, const MotionLimits& limits, double step_s) {
  const double farthest = limits.max_velocity * step_s;
  const double next =
      position_ + std::clamp(std::clamp(goal, limits.lower, limits.upper) - position_, -farthest, farthest);
  velocity_ = (next - position_) / step_s;
  position_ = next;
}

void SetPoint::hold(double position) {
  position_ = position;
  velocity_ = 0;
}

}  // namespace extperfc::simulate
