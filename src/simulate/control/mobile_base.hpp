#pragma once

#include <array>
#include <functional>

#include "extperfc/base/rng.hpp"
#include "extperfc/simulate/robot_io.hpp"
#include "extperfc/simulate/simulator.hpp"

namespace extperfc::simulate {

/// Wheel speeds [rad/s] (front left, front right, rear left, rear right) that move a mecanum base so, and
/// back.
[[nodiscard]] std::array<double, 4> wheel_speeds(const Twist2& twist);
[[nodiscard]] Twist2 twist_of(const std::array<double, 4>& wheel_speeds);

/// Error that wanders about zero: an Ornstein-Uhlenbeck process with a correlation time of half a second.
class Wander {
 public:
  explicit Wander(double sigma = 0) : sigma_(sigma) {}
  double step(Rng& rng, double step_s);

 private:
  double sigma_;  // standard deviation in the long run
  double value_{0};
};

/// Holonomic base on four mecanum wheels (45 degree rollers): kinematic, with limited acceleration, slip, and
/// the odometry that its wheels measure. Kinematics: the standard ones of a mecanum drive, wheel geometry of
/// Dataspeed's base.
class MobileBase {
 public:
  MobileBase(const BaseParams& params, const Pose2& start, std::uint64_t seed);

  void command(const Twist2& velocity, double now_s);
  /// One step. `collides(pose)` returns whether the base cannot stand there; it then stays and its wheels go
  /// on turning.
  void step(double now_s, double step_s, const std::function<bool(const Pose2&)>& collides);
  /// Elsewhere, at rest; odometry stays.
  void place(const Pose2& pose);
  /// Fraction of a wheel's motion that is lost, [0, 1].
  void set_slip(int wheel, double fraction) { fault_slip_[wheel] = fraction; }

  [[nodiscard]] const BaseState& state() const { return state_; }
  [[nodiscard]] const ImuSample& imu() const { return imu_; }

 private:
  [[nodiscard]] Twist2 limited_command(double now_s, double step_s) const;
  [[nodiscard]] Twist2 with_slip(const std::array<double, 4>& wheels, double step_s);
  void measure(const std::array<double, 4>& wheels, double step_s);
  void sense(const Twist2& before, double step_s);

  BaseParams params_;
  Rng rng_;
  BaseState state_;
  ImuSample imu_;
  Twist2 wanted_;  // last command
  Twist2 drive_;   // what the wheels do now
  double command_time_s_{-1e9};
  double gyro_bias_{0};
  std::array<Wander, 4> slip_;
  std::array<Wander, 4> encoder_error_;
  std::array<double, 4> fault_slip_{};
};

}  // namespace extperfc::simulate
