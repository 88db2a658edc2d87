#include "simulate/control/head_controller.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::simulate {

void HeadController::pan_to(double target_rad, double speed_ratio) {
  if (!std::isfinite(target_rad) || !std::isfinite(speed_ratio)) return;
  target_ = std::clamp(target_rad, limits_.lower, limits_.upper);
  speed_ratio_ = std::clamp(speed_ratio, 0.0, 1.0);
}

double HeadController::step(double now_s, double step_s, bool may_move, bool stuck) {
  if (may_move && !stuck) {
    MotionLimits slowed = limits_;
    slowed.max_velocity *= std::max(speed_ratio_, 1e-3);
    set_point_.move_to(target_, slowed, step_s);
  } else {
    set_point_.hold(set_point_.position());
  }
  state_.pan = set_point_.position();
  state_.turning = set_point_.velocity() != 0;
  state_.nodding = now_s < nod_until_s_;
  return state_.pan;
}

}  // namespace extperfc::simulate
