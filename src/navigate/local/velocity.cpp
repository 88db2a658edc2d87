#include "extperfc/navigate/velocity.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "extperfc/base/math.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kMaxSpeed_m_s = 10;
constexpr double kMaxSpeed_rad_s = 20;
constexpr double kMaxAcceleration = 100;  // [m/s^2], [rad/s^2]

Result<void> in_range(const char* name, double value, double low, bool low_included, double high) {
  const bool inside = std::isfinite(value) && value <= high && (low_included ? value >= low : value > low);
  if (inside) return {};
  return fail(ErrorCode::kInvalidArgument, std::string(name) + " is " + std::to_string(value) + ": set it " +
                                               (low_included ? "from " : "above ") + std::to_string(low) +
                                               " to " + std::to_string(high));
}

/// The part of an ellipse's half axis that a speed along it uses; a half axis of 0 allows no speed.
double part_of(double speed, double half_axis) {
  return half_axis > 0 ? speed / half_axis : 0;
}

}  // namespace

Result<void> validate(const VelocityLimits& limits) {
  const Result<void> checks[] = {
      in_range("max_vx_m_s", limits.max_vx_m_s, 0, false, kMaxSpeed_m_s),
      in_range("min_vx_m_s", limits.min_vx_m_s, -kMaxSpeed_m_s, true, 0),
      in_range("max_vy_m_s", limits.max_vy_m_s, 0, true, kMaxSpeed_m_s),
      in_range("max_wz_rad_s", limits.max_wz_rad_s, 0, false, kMaxSpeed_rad_s),
      in_range("acc_x_m_s2", limits.acc_x_m_s2, 0, false, kMaxAcceleration),
      in_range("acc_y_m_s2", limits.acc_y_m_s2, 0, false, kMaxAcceleration),
      in_range("acc_wz_rad_s2", limits.acc_wz_rad_s2, 0, false, kMaxAcceleration),
  };
  for (const Result<void>& check : checks)
    if (!check) return check;
  return {};
}

Twist2 limited(const Twist2& wanted, const VelocityLimits& limits, double factor) {
  const double along = wanted.vx >= 0 ? limits.max_vx_m_s : -limits.min_vx_m_s;
  Twist2 result{along > 0 ? wanted.vx : 0, limits.max_vy_m_s > 0 ? wanted.vy : 0, wanted.wz};
  const double used = std::hypot(part_of(result.vx, along), part_of(result.vy, limits.max_vy_m_s));
  if (used > factor) {
    result.vx *= factor / used;
    result.vy *= factor / used;
  }
  const double max_wz = factor * limits.max_wz_rad_s;
  result.wz = std::clamp(result.wz, -max_wz, max_wz);
  return result;
}

Twist2 limited_change(const Twist2& wanted, const Twist2& current, const VelocityLimits& limits, double dt_s,
                      double factor) {
  const Twist2 target = limited(wanted, limits, factor);
  const Twist2 change{target.vx - current.vx, target.vy - current.vy, target.wz - current.wz};
  const double translation = std::hypot(change.vx / limits.acc_x_m_s2, change.vy / limits.acc_y_m_s2);
  const double needed_s = std::max(translation, std::abs(change.wz) / limits.acc_wz_rad_s2);
  if (needed_s <= dt_s) return target;
  const double ratio = dt_s / needed_s;
  return {current.vx + ratio * change.vx, current.vy + ratio * change.vy, current.wz + ratio * change.wz};
}

}  // namespace extperfc::navigate
