#include "mapping/scan_points.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

namespace extperfc::mapping {

namespace {

constexpr int kReach = 4;                 // neighbours on either side that may belong to the same surface
constexpr float kSurfaceReachM = 0.25F;   // ... when they are this near
constexpr float kReachInSpacings = 2.6F;  // ... or this many times as far as rays are apart there
constexpr float kStraight = 0.08F;        // variance across over variance along that still is a line
constexpr float kThinnestM = 0.03F;       // along the surface, between points that are kept
constexpr std::size_t kMaxPoints = 400;
constexpr std::size_t kMaxClearRays = 120;

struct Returns {
  std::vector<Eigen::Vector2f> position;  ///< scanner's frame
  std::vector<float> range;
  std::vector<std::size_t> ray;
};

Eigen::Vector2f along(const LaserScan& scan, std::size_t ray, float range) {
  const double angle = scan.angle_min + static_cast<double>(ray) * scan.angle_increment;
  return {range * static_cast<float>(std::cos(angle)), range * static_cast<float>(std::sin(angle))};
}

/// The unit normal of the line through the returns within `reach_m` and `rays` rays of `middle`, facing the
/// scanner at the origin; zero when they are fewer than `min_returns` or their variance across the line is
/// more than `straight` of that along it.
Eigen::Vector2f line_normal(const Returns& returns, std::size_t middle, float reach_m, int rays,
                            int min_returns, float straight) {
  const Eigen::Vector2f& centre = returns.position[middle];
  Eigen::Vector2f sum = Eigen::Vector2f::Zero();
  Eigen::Matrix2f squares = Eigen::Matrix2f::Zero();
  int count = 0;
  const auto first = static_cast<std::ptrdiff_t>(middle) - rays;
  for (std::ptrdiff_t i = first; i <= first + 2 * rays; ++i) {
    if (i < 0 || i >= static_cast<std::ptrdiff_t>(returns.position.size())) continue;
    const Eigen::Vector2f d = returns.position[static_cast<std::size_t>(i)] - centre;
    if (d.squaredNorm() > reach_m * reach_m) continue;
    sum += d;
    squares += d * d.transpose();
    ++count;
  }
  if (count < min_returns) return Eigen::Vector2f::Zero();
  const Eigen::Vector2f mean = sum / static_cast<float>(count);
  const Eigen::Matrix2f spread = squares / static_cast<float>(count) - mean * mean.transpose();
  const float difference = spread(0, 0) - spread(1, 1);
  const float half_spread = std::sqrt(difference * difference / 4 + spread(0, 1) * spread(0, 1));
  const float half_trace = (spread(0, 0) + spread(1, 1)) / 2;
  if (half_trace - half_spread > straight * (half_trace + half_spread)) return Eigen::Vector2f::Zero();
  const float direction = 0.5F * std::atan2(2 * spread(0, 1), difference);
  Eigen::Vector2f normal(-std::sin(direction), std::cos(direction));
  if (normal.dot(centre) > 0) normal = -normal;
  return normal;
}

/// The normal from near neighbours, or, where a wall is seen at a grazing angle and returns are far apart,
/// from more distant ones that stand in line very closely.
Eigen::Vector2f surface_normal(const Returns& returns, std::size_t middle, float ray_spacing_rad) {
  const float reach = std::max(kSurfaceReachM, kReachInSpacings * returns.range[middle] * ray_spacing_rad);
  Eigen::Vector2f normal = line_normal(returns, middle, reach, kReach, 3, kStraight);
  if (normal.squaredNorm() > 0) return normal;
  constexpr float kGrazingReachM = 4.0F;
  constexpr int kGrazingRays = 2;
  constexpr float kGrazingStraight = 0.002F;
  return line_normal(returns, middle, kGrazingReachM, kGrazingRays, 4, kGrazingStraight);
}

/// Keeps every point that is `spacing` of surface away from the last one kept.
std::vector<std::size_t> thin(const std::vector<Eigen::Vector2f>& points, float spacing) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (kept.empty() || (points[i] - points[kept.back()]).norm() >= spacing) kept.push_back(i);
  return kept;
}

/// Indices of the points to keep: spaced evenly along surfaces, at most kMaxPoints.
std::vector<std::size_t> choose(const std::vector<Eigen::Vector2f>& points) {
  auto kept = thin(points, kThinnestM);
  for (float spacing = 1.5F * kThinnestM; kept.size() > kMaxPoints; spacing *= 1.3F) {
    kept = thin(points, spacing);
    if (spacing > 1.0F) kept.resize(std::min(kept.size(), kMaxPoints));
  }
  return kept;
}

}  // namespace

ScanPoints scan_points(const LaserScan& scan, const ScanPointLimits& limits) {
  const auto nearest = static_cast<float>(std::max(scan.range_min, 1e-3));
  constexpr double kFarthestM = 2000.0;  // longer than any mobile robot's scanner measures
  const auto farthest = static_cast<float>(std::min(
      {limits.max_usable_range_m > 0 ? limits.max_usable_range_m : kFarthestM, scan.range_max, kFarthestM}));
  const auto clear_to = static_cast<float>(std::min(limits.max_range_m, scan.range_max));
  Returns returns;
  std::vector<Eigen::Vector2f> clear;
  for (std::size_t ray = 0; ray < scan.ranges.size(); ++ray) {
    const float range = scan.ranges[ray];
    if (!(range >= nearest)) continue;  // NaN fails
    if (range <= farthest) {
      returns.position.push_back(along(scan, ray, range));
      returns.range.push_back(range);
    } else if (range <= static_cast<float>(scan.range_max)) {
      clear.push_back(along(scan, ray, farthest));  // it met something, farther away than counts
    } else if (clear_to > nearest) {
      clear.push_back(along(scan, ray, std::min(clear_to, farthest)));
    }
  }
  const auto c = static_cast<float>(std::cos(scan.base_T_sensor.yaw));
  const auto s = static_cast<float>(std::sin(scan.base_T_sensor.yaw));
  Eigen::Matrix2f rotation;
  rotation << c, -s, s, c;
  ScanPoints points;
  points.scanner = {static_cast<float>(scan.base_T_sensor.x), static_cast<float>(scan.base_T_sensor.y)};
  const auto spacing = static_cast<float>(std::abs(scan.angle_increment));
  for (const std::size_t i : choose(returns.position))
    points.surface.push_back(
        {rotation * returns.position[i] + points.scanner, rotation * surface_normal(returns, i, spacing)});
  const std::size_t step = 1 + clear.size() / kMaxClearRays;
  for (std::size_t i = 0; i < clear.size(); i += step)
    points.clear.push_back(rotation * clear[i] + points.scanner);
  return points;
}

}  // namespace extperfc::mapping
