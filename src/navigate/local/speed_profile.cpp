#include "navigate/local/speed_profile.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::navigate {

namespace {

constexpr float kBrakingPart = 0.6F;   // of the accelerations: the rest corrects errors
constexpr float kCornerPart = 0.6F;    // the same, to change direction
constexpr float kSlowest_m_s = 0.02F;  // of stations that are not the end

/// Units of a limit that one unit of length along the station's motion takes; 0: none.
struct Use {
  float speed{0};
  float acceleration{0};
};

Use use_of(const VelocityLimits& limits, const Station& at) {
  const float c = std::cos(at.yaw);
  const float s = std::sin(at.yaw);
  const float along = c * at.dx + s * at.dy;
  const float across = -s * at.dx + c * at.dy;
  const double front = along >= 0 || limits.min_vx_m_s == 0 ? limits.max_vx_m_s : -limits.min_vx_m_s;
  const float x = along / static_cast<float>(front);
  const float y = limits.max_vy_m_s > 0 ? across / static_cast<float>(limits.max_vy_m_s) : 0.0F;
  const float yaw = std::abs(at.dyaw);
  const float acc = std::hypot(along / static_cast<float>(limits.acc_x_m_s2),
                               across / static_cast<float>(limits.acc_y_m_s2));
  return {std::max(std::hypot(x, y), yaw / static_cast<float>(limits.max_wz_rad_s)),
          std::max(acc, yaw / static_cast<float>(limits.acc_wz_rad_s2))};
}

/// Change of the motion's direction by length [1/m].
float curvature(const std::vector<Station>& stations, std::size_t i) {
  constexpr std::size_t kReach = 2;
  const Station& a = stations[i > kReach ? i - kReach : 0];
  const Station& b = stations[std::min(stations.size() - 1, i + kReach)];
  const float length = b.s - a.s;
  if (length < 1e-3F) return 0;
  const auto radian = static_cast<float>(kRadian_m);
  const float dx = b.dx - a.dx;
  const float dy = b.dy - a.dy;
  const float dyaw = radian * (b.dyaw - a.dyaw);
  return std::sqrt(dx * dx + dy * dy + dyaw * dyaw) / length;
}

}  // namespace

float clearance_speed(const SpeedRules& rules, float clearance_m) {
  const auto full = static_cast<float>(rules.limits.max_vx_m_s);
  const auto narrow = std::min(full, static_cast<float>(rules.narrow_speed_m_s));
  const float part = std::clamp(clearance_m / static_cast<float>(rules.wide_clearance_m), 0.0F, 1.0F);
  return narrow + part * (full - narrow);
}

void fill_speed_profile(const SpeedRules& rules, const ClearanceField& field, const Outline& outline,
                        std::vector<Station>& stations) {
  const auto wide = static_cast<float>(rules.wide_clearance_m);
  const auto factor = static_cast<float>(rules.speed_factor);
  const auto acceleration =
      static_cast<float>(std::min(rules.limits.acc_x_m_s2, std::max(0.1, rules.limits.acc_y_m_s2)));
  const std::size_t last = stations.size() - 1;
  for (std::size_t i = last + 1; i-- > 0;) {
    Station& at = stations[i];
    const Use use = use_of(rules.limits, at);
    at.clearance_m = field.clearance(outline, at.x, at.y, std::cos(at.yaw), std::sin(at.yaw), wide);
    at.cost = field.cost(at.x, at.y);
    const float translation = std::max(0.2F, std::hypot(at.dx, at.dy));
    float rate = clearance_speed(rules, at.clearance_m) / translation;
    if (use.speed > 0) rate = std::min(rate, 1 / use.speed);
    rate *= factor;
    const float bend = curvature(stations, i);
    if (bend > 0) rate = std::min(rate, std::sqrt(kCornerPart * acceleration / bend));
    if (i < last) {
      const float brake = kBrakingPart / std::max(use.acceleration, 0.05F);
      const float next = stations[i + 1].max_rate;
      rate = std::min(rate, std::sqrt(next * next + 2 * brake * (stations[i + 1].s - at.s)));
      rate = std::max(rate, factor > 0 ? kSlowest_m_s : 0.0F);
    } else if (rules.stops_at_end) {
      rate = 0;
    }
    at.max_rate = rate;
  }
}

}  // namespace extperfc::navigate
