#include "simulate/control/arm_controller.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::simulate {
namespace {

/// A set point runs ahead of a joint that something holds back by this much at most [rad].
constexpr double kLongestLead = 0.2;

}  // namespace

ArmController::ArmController(const std::array<MotionLimits, kArmJoints>& limits, const ArmValues& start,
                             double timeout_s)
    : limits_(limits), timeout_s_(timeout_s) {
  for (int i = 0; i < kArmJoints; ++i) set_points_[i] = SetPoint(start[i]);
}

void ArmController::command(const ArmCommand& command, double now_s) {
  command_ = command;
  command_time_s_ = now_s;
}

void ArmController::set_speed_ratio(double ratio) {
  speed_ratio_ = std::clamp(ratio, 0.0, 1.0);
}

void ArmController::set_timeout(double timeout_s) {
  timeout_s_ = std::clamp(timeout_s, 0.001, 1.0);
}

void ArmController::set_stuck(int joint, bool stuck) {
  if (stuck) set_points_[joint].hold(set_points_[joint].position());
  stuck_[joint] = stuck;
}

ArmValues ArmController::set_points() const {
  ArmValues values{};
  for (int i = 0; i < kArmJoints; ++i) values[i] = set_points_[i].position();
  return values;
}

void ArmController::leave_torque_mode(const ArmMeasurement& measured) {
  for (int i = 0; i < kArmJoints; ++i) set_points_[i].hold(measured.position[i]);
  in_torque_mode_ = false;
}

JointTarget ArmController::step_joint(int joint, bool fresh, double step_s, const ArmMeasurement& measured) {
  SetPoint& point = set_points_[joint];
  const MotionLimits& limits = limits_[joint];
  const auto& value = command_.values[joint];
  if (!fresh || !value) {
    point.move_at(0, limits, step_s);
  } else if (command_.mode == ArmMode::kPosition) {
    MotionLimits slowed = limits;
    slowed.max_velocity *= std::max(speed_ratio_, 1e-3);
    point.move_to(*value, slowed, step_s);
  } else if (command_.mode == ArmMode::kRawPosition) {
    point.follow(*value, limits, step_s);
  } else {
    point.move_at(*value, limits, step_s);
  }
  const double led = std::clamp(point.position(), measured.position[joint] - kLongestLead,
                                measured.position[joint] + kLongestLead);
  if (led != point.position()) point.hold(led);
  return {Drive::kPosition, point.position(), point.velocity(), 0, 0};
}

ArmController::Targets ArmController::step(double now_s, double step_s, bool may_move,
                                           const ArmMeasurement& measured) {
  const bool fresh = may_move && now_s - command_time_s_ < timeout_s_;
  const bool torque = fresh && command_.mode == ArmMode::kTorque;
  if (in_torque_mode_ && !torque) leave_torque_mode(measured);
  in_torque_mode_ = torque;
  Targets targets;
  for (int i = 0; i < kArmJoints; ++i) {
    if (!may_move || stuck_[i]) {
      set_points_[i].hold(set_points_[i].position());
      targets[i] = {Drive::kPosition, set_points_[i].position(), 0, 0, 0};
    } else if (torque) {
      set_points_[i].hold(measured.position[i]);
      targets[i] = {Drive::kEffort, 0, 0, command_.values[i].value_or(0) + measured.gravity[i], 0};
    } else {
      targets[i] = step_joint(i, fresh, step_s, measured);
    }
  }
  return targets;
}

}  // namespace extperfc::simulate
