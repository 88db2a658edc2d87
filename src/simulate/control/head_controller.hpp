#pragma once

#include "extperfc/simulate/robot_io.hpp"

#include "simulate/control/set_point.hpp"

namespace extperfc::simulate {

/// Pan and nod of the head. The nod of the real head has no sensor and no joint in its description: here it
/// is a flag that stands for as long as a nod takes.
class HeadController {
 public:
  explicit HeadController(const MotionLimits& limits) : limits_(limits) {}

  void pan_to(double target_rad, double speed_ratio);
  void nod(double now_s) { nod_until_s_ = now_s + kNodS; }
  /// Where the head shall be after the step [rad].
  double step(double now_s, double step_s, bool may_move, bool stuck);
  [[nodiscard]] const HeadState& state() const { return state_; }
  [[nodiscard]] double velocity() const { return set_point_.velocity(); }

 private:
  static constexpr double kNodS = 1.0;

  MotionLimits limits_;
  SetPoint set_point_;
  double target_{0};
  double speed_ratio_{1};
  double nod_until_s_{-1};
  HeadState state_;
};

}  // namespace extperfc::simulate
