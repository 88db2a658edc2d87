#pragma once

#include <array>

#include "extperfc/simulate/bodies.hpp"
#include "extperfc/simulate/robot_io.hpp"

#include "simulate/control/set_point.hpp"

namespace extperfc::simulate {

/// What is measured of one arm before a step.
struct ArmMeasurement {
  ArmValues position{};  ///< [rad]
  ArmValues gravity{};   ///< effort that holds the arm [N m]
};

/// One arm's joint controllers: Baxter's command modes, their time-out and the limits of rate and
/// acceleration.
class ArmController {
 public:
  using Targets = std::array<JointTarget, kArmJoints>;

  ArmController(const std::array<MotionLimits, kArmJoints>& limits, const ArmValues& start, double timeout_s);

  void command(const ArmCommand& command, double now_s);
  void set_speed_ratio(double ratio);
  void set_timeout(double timeout_s);

  /// Targets for the next step. An arm that is not allowed to move holds its position at once.
  [[nodiscard]] Targets step(double now_s, double step_s, bool may_move, const ArmMeasurement& measured);

  [[nodiscard]] ArmValues set_points() const;
  /// The joint ignores commands and stays where it is; false releases it.
  void set_stuck(int joint, bool stuck);

 private:
  [[nodiscard]] JointTarget step_joint(int joint, bool fresh, double step_s, const ArmMeasurement& measured);
  void leave_torque_mode(const ArmMeasurement& measured);

  std::array<MotionLimits, kArmJoints> limits_;
  std::array<SetPoint, kArmJoints> set_points_;
  std::array<bool, kArmJoints> stuck_{};
  ArmCommand command_;
  double command_time_s_{-1e9};
  double timeout_s_;
  double speed_ratio_{0.3};  // Baxter's own default
  bool in_torque_mode_{false};
};

}  // namespace extperfc::simulate
