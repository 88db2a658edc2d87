#include "navigate/local/guide.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::navigate {

namespace {

constexpr double kFollowGain_per_s = 1.8;  // of position and heading
constexpr double kFar_m = 0.3;             // deviation at which the path's own velocity is halved
constexpr double kLead_s = 0.15;           // the path's velocity is taken so much ahead
constexpr double kAcross_per_m2 = 8.0;     // of a differential base: yaw rate per deviation and speed
constexpr double kHeading_per_m = 4.0;     // the same for the heading; critically damped
constexpr double kBearing_per_s = 2.0;

float distance2(const Station& at, float x, float y, float yaw) {
  const float dx = x - at.x;
  const float dy = y - at.y;
  const float dyaw = static_cast<float>(kRadian_m) * (yaw - at.yaw);
  return dx * dx + dy * dy + dyaw * dyaw;
}

}  // namespace

std::size_t nearest_station(const std::vector<Station>& stations, std::size_t index, float x_m, float y_m,
                            float yaw_rad) {
  constexpr int kMaxSteps = 6;
  float best = distance2(stations[index], x_m, y_m, yaw_rad);
  for (int i = 0; i < kMaxSteps && index + 1 < stations.size(); ++i) {
    const float next = distance2(stations[index + 1], x_m, y_m, yaw_rad);
    if (next > best) break;
    best = next;
    ++index;
  }
  for (int i = 0; i < kMaxSteps && index > 0; ++i) {
    const float before = distance2(stations[index - 1], x_m, y_m, yaw_rad);
    if (before >= best) break;
    best = before;
    --index;
  }
  return index;
}

Twist2 Guide::velocity(const std::vector<Station>& stations, std::size_t index, const Pose2& pose,
                       double rate_factor) const {
  const double rate = rate_factor * stations[index].max_rate;
  const auto ahead = static_cast<std::size_t>(std::lround(std::max(0.0, rate) * kLead_s / kStationStep_m));
  const Station& lead = stations[std::min(stations.size() - 1, index + ahead)];
  Station at = stations[index];
  at.dx = lead.dx;
  at.dy = lead.dy;
  at.dyaw = lead.dyaw;
  const double reached = rate_factor < 0 ? rate : std::min(rate, std::max(0.02, double{lead.max_rate}));
  return base_ == BaseKind::kHolonomic ? holonomic(at, pose, reached) : differential(at, pose, reached);
}

Twist2 Guide::holonomic(const Station& at, const Pose2& pose, double rate) const {
  // Only the deviation across the path: along it the profile decides.
  const double ex = at.x - pose.x;
  const double ey = at.y - pose.y;
  const double length2 = at.dx * at.dx + at.dy * at.dy;
  const double along = length2 > 0.04 ? (ex * at.dx + ey * at.dy) / length2 : 0.0;
  const double across_x = ex - along * at.dx;
  const double across_y = ey - along * at.dy;
  const double slowed = rate / (1 + std::hypot(across_x, across_y) / kFar_m);
  const double vx = slowed * at.dx + kFollowGain_per_s * across_x;
  const double vy = slowed * at.dy + kFollowGain_per_s * across_y;
  const double c = std::cos(pose.yaw);
  const double s = std::sin(pose.yaw);
  const double wz = slowed * at.dyaw + kFollowGain_per_s * (at.yaw - pose.yaw);
  return {c * vx + s * vy, -s * vx + c * vy, wz};
}

Twist2 Guide::differential(const Station& at, const Pose2& pose, double rate) const {
  const double c = std::cos(at.yaw);
  const double s = std::sin(at.yaw);
  const double along = c * at.dx + s * at.dy;  // below 0: the path goes backwards
  const double ex = at.x - pose.x;
  const double ey = at.y - pose.y;
  const double across = -s * ex + c * ey;
  const double off = at.yaw - pose.yaw;
  const double vx = rate * along * std::max(0.0, std::cos(off)) / (1 + std::abs(across) / kFar_m);
  const bool rotates = std::abs(along) < 0.5;
  if (rotates) return {vx, 0, rate * at.dyaw + kBearing_per_s * off};
  const double wz = vx * at.dyaw / along + kAcross_per_m2 * vx * across +
                    std::max(kHeading_per_m * std::abs(vx), kBearing_per_s * (std::abs(off) > 0.5)) * off;
  return {vx, 0, wz};
}

}  // namespace extperfc::navigate
