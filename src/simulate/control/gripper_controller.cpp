#include "simulate/control/gripper_controller.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::simulate {
namespace {

using Kind = GripperCommand::Kind;

bool is_percent(const std::optional<double>& value) {
  return !value || (*value >= 0 && *value <= 100);
}

}  // namespace

GripperController::GripperController(const MotionLimits& limits, double max_force_n, double start_m)
    : limits_(limits), max_force_n_(max_force_n), set_point_(start_m), goal_m_(start_m) {
  state_.position_percent = percent(start_m);
}

double GripperController::percent(double finger_m) const {
  return std::clamp(100 * (finger_m - limits_.lower) / (limits_.upper - limits_.lower), 0.0, 100.0);
}

double GripperController::metres(double position_percent) const {
  return limits_.lower + position_percent / 100 * (limits_.upper - limits_.lower);
}

Result<void> GripperController::configure(const GripperCommand& command) {
  if (!is_percent(command.velocity_percent) || !is_percent(command.moving_force_percent) ||
      !is_percent(command.holding_force_percent) || !is_percent(command.dead_zone_percent))
    return fail(ErrorCode::kInvalidArgument,
                "gripper: velocity, moving_force, holding_force and dead_zone are per cent: use 0 to 100");
  velocity_percent_ = command.velocity_percent.value_or(velocity_percent_);
  moving_force_percent_ = command.moving_force_percent.value_or(moving_force_percent_);
  holding_force_percent_ = command.holding_force_percent.value_or(holding_force_percent_);
  dead_zone_percent_ = command.dead_zone_percent.value_or(dead_zone_percent_);
  return {};
}

void GripperController::begin_calibration() {
  calibration_ = Phase::kClosing;
  state_.calibrated = state_.ready = false;
  goal_m_ = limits_.lower;
  closing_ = true;
}

Result<void> GripperController::command(const GripperCommand& command) {
  if (auto configured = configure(command); !configured) return configured;
  switch (command.kind) {
    case Kind::kGoTo:
      if (!state_.calibrated)
        return fail(ErrorCode::kFailed, "gripper: it is not calibrated: send the command calibrate first");
      if (!(command.position_percent >= 0 && command.position_percent <= 100))
        return fail(ErrorCode::kInvalidArgument,
                    "gripper: position is per cent: use 0 (closed) to 100 (open)");
      closing_ = metres(command.position_percent) < set_point_.position();
      goal_m_ = metres(command.position_percent);
      break;
    case Kind::kStop:
      goal_m_ = set_point_.position();
      closing_ = false;
      break;
    case Kind::kCalibrate:
      begin_calibration();
      break;
    case Kind::kClearCalibration:
    case Kind::kReboot:
      state_ = GripperState{};
      calibration_ = Phase::kIdle;
      goal_m_ = set_point_.position();
      break;
    case Kind::kReset:
      state_.error = state_.missed = false;
      break;
    case Kind::kNoop:
    case Kind::kConfigure:
      break;
  }
  return {};
}

void GripperController::advance_calibration(const GripperMeasurement& measured) {
  // Against the end, or against what is between the fingers, and open again.
  if (calibration_ == Phase::kClosing && (set_point_.position() <= limits_.lower || measured.touches)) {
    calibration_ = Phase::kOpening;
    goal_m_ = limits_.upper;
    closing_ = false;
  } else if (calibration_ == Phase::kOpening && set_point_.position() >= limits_.upper) {
    calibration_ = Phase::kIdle;
    calibrate_at_once();
  }
}

JointTarget GripperController::step(double step_s, bool may_move, const GripperMeasurement& measured) {
  advance_calibration(measured);
  MotionLimits limits = limits_;
  limits.max_velocity *= std::max(velocity_percent_, 1.0) / 100;
  if (!may_move) {
    set_point_.hold(set_point_.position());
  } else {
    set_point_.move_to(goal_m_, limits, step_s);
  }
  // Fingers that something stops press with a set point at most 5 mm beyond it, so that they open at once.
  constexpr double kDeepestPress = 0.005;
  set_point_ = [&] {
    SetPoint point = set_point_;
    if (measured.touches && point.position() < measured.finger_m - kDeepestPress)
      point.hold(measured.finger_m - kDeepestPress);
    return point;
  }();
  const double dead_zone_m = dead_zone_percent_ / 100 * (limits_.upper - limits_.lower);
  const bool arrived = std::abs(measured.finger_m - goal_m_) <= dead_zone_m;
  state_.gripping = measured.touches && closing_;
  state_.moving = may_move && !state_.gripping && !arrived;
  state_.missed = closing_ && arrived && !measured.touches && percent(goal_m_) <= dead_zone_percent_;
  state_.position_percent = percent(measured.finger_m);
  state_.force_percent = std::clamp(100 * measured.force_n / max_force_n_, 0.0, 100.0);
  const double force = state_.gripping ? holding_force_percent_ : moving_force_percent_;
  return {Drive::kPosition, set_point_.position(), set_point_.velocity(), 0,
          std::max(force, 1.0) / 100 * max_force_n_};
}

}  // namespace extperfc::simulate
