#pragma once

#include "extperfc/simulate/bodies.hpp"
#include "extperfc/simulate/robot_io.hpp"

#include "simulate/control/set_point.hpp"

namespace extperfc::simulate {

/// What is measured of a gripper before a step.
struct GripperMeasurement {
  double finger_m{0};   ///< travel of the driving finger
  bool touches{false};  ///< both fingers touch one loose body
  double force_n{0};
};

/// Baxter's electric gripper: position in per cent, forces, calibration. A gripper that was not calibrated
/// refuses to go anywhere, as the real one does.
class GripperController {
 public:
  /// `limits` of the driving finger [m]; `max_force_n` of one finger.
  GripperController(const MotionLimits& limits, double max_force_n, double start_m);

  /// Error: a value out of its range, or a move before the calibration.
  [[nodiscard]] Result<void> command(const GripperCommand& command);
  [[nodiscard]] JointTarget step(double step_s, bool may_move, const GripperMeasurement& measured);
  [[nodiscard]] GripperState state() const { return state_; }
  /// As after a calibration.
  void calibrate_at_once() { state_.calibrated = state_.ready = true; }

 private:
  [[nodiscard]] Result<void> configure(const GripperCommand& command);
  void begin_calibration();
  void advance_calibration(const GripperMeasurement& measured);
  [[nodiscard]] double percent(double finger_m) const;
  [[nodiscard]] double metres(double position_percent) const;

  enum class Phase { kIdle, kClosing, kOpening };

  MotionLimits limits_;
  double max_force_n_;
  SetPoint set_point_;
  double goal_m_;
  bool closing_{false};  ///< the last goal lay on the closing side
  Phase calibration_{Phase::kIdle};
  // Baxter's own defaults.
  double velocity_percent_{50};
  double moving_force_percent_{40};
  double holding_force_percent_{30};
  double dead_zone_percent_{5};
  GripperState state_;
};

}  // namespace extperfc::simulate
