#pragma once

#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

enum class BaseKind {
  kHolonomic,     ///< vx, vy and wz at once
  kDifferential,  ///< vy is always 0
};

/// What the base may do. A holonomic base's translation lies in the ellipse of max_vx (min_vx backwards) and
/// max_vy.
struct VelocityLimits {
  double max_vx_m_s{0.8};     ///< forwards, > 0
  double min_vx_m_s{-0.4};    ///< backwards, <= 0
  double max_vy_m_s{0.5};     ///< to either side, >= 0; a differential base: 0
  double max_wz_rad_s{1.2};   ///< > 0
  double acc_x_m_s2{1.0};     ///< > 0
  double acc_y_m_s2{1.0};     ///< > 0
  double acc_wz_rad_s2{2.5};  ///< > 0
};

/// An error that names the first limit out of its range.
[[nodiscard]] Result<void> validate(const VelocityLimits& limits);

/// The nearest admissible velocity: direction of the translation kept. `factor` in [0, 1] scales the limits
/// of speed.
[[nodiscard]] Twist2 limited(const Twist2& wanted, const VelocityLimits& limits, double factor = 1.0);

/// limited(), and no farther from `current` than the accelerations allow in dt_s; direction of the change
/// kept.
[[nodiscard]] Twist2 limited_change(const Twist2& wanted, const Twist2& current, const VelocityLimits& limits,
                                    double dt_s, double factor = 1.0);

}  // namespace extperfc::navigate
