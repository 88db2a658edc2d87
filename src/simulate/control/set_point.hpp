#pragma once

namespace extperfc::simulate {

/// What a joint may do.
struct MotionLimits {
  double lower{0};         ///< [rad] or [m]
  double upper{0};         ///< [rad] or [m]
  double max_velocity{1};  ///< > 0 [1/s]
  double max_accel{1};     ///< > 0 [1/s^2]
};

/// Position that moves within limits of velocity and acceleration, one step at a time.
class SetPoint {
 public:
  explicit SetPoint(double position = 0) : position_(position) {}

  [[nodiscard]] double position() const { return position_; }
  [[nodiscard]] double velocity() const { return velocity_; }

  /// A step towards `goal`, braking in time: never overshoots it from rest.
  void move_to(double goal, const MotionLimits& limits, double step_s);
  /// A step with the wanted velocity, braking before the ends of the range.
  void move_at(double wanted_velocity, const MotionLimits& limits, double step_s);
  /// A step that takes `goal` as it is, as far as the largest velocity allows.
  void follow(double goal, const MotionLimits& limits, double step_s);
  /// At rest here from now on.
  void hold(double position);

 private:
  void advance(double wanted_velocity, const MotionLimits& limits, double step_s);

  double position_{0};
  double velocity_{0};
};

/// The largest speed from which a body that brakes with `accel`, in steps of `step_s`, stops within
/// `distance` >= 0.
[[nodiscard]] double braking_speed(double distance, double accel, double step_s);

}  // namespace extperfc::simulate
