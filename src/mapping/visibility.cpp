#include "mapping/visibility.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/base/arc_tangent.hpp"
#include "extperfc/base/math.hpp"

namespace extperfc::mapping {

namespace {

constexpr float kMarginM = 0.3F;  // a surface must stand so far in front of what was seen

std::size_t bin_of(const Eigen::Vector2f& ray, std::size_t bins) {
  // Whole degrees, where the rays of many scanners lie, are the middles of bins.
  const float revolutions = (arc_tangent(ray.y(), ray.x()) + kPiF) / (2 * kPiF);
  const auto bin =
      static_cast<std::size_t>(std::lrint(std::max(0.0F, revolutions) * static_cast<float>(bins)));
  return bin < bins ? bin : bin - bins;
}

struct Transform {
  explicit Transform(const Pose2& pose)
      : c(static_cast<float>(std::cos(pose.yaw))),
        s(static_cast<float>(std::sin(pose.yaw))),
        x(static_cast<float>(pose.x)),
        y(static_cast<float>(pose.y)) {}
  Eigen::Vector2f operator*(const Eigen::Vector2f& p) const {
    return {c * p.x() - s * p.y() + x, s * p.x() + c * p.y() + y};
  }
  float c;
  float s;
  float x;
  float y;
};

}  // namespace

RangeProfile::RangeProfile(const ScanPoints& points) : scanner_(points.scanner) {
  std::array<float, kBins> nearest{};
  for (const SurfacePoint& point : points.surface) {
    const Eigen::Vector2f ray = point.position - scanner_;
    float& range = nearest[bin_of(ray, kBins)];
    const float length = ray.norm();
    if (range == 0.0F || length < range) range = length;
  }
  // At the edge of an object a neighbour is nearer: the nearest of three directions counts.
  for (std::size_t i = 0; i < kBins; ++i) {
    if (nearest[i] == 0.0F) continue;
    float smallest = nearest[i];
    for (const std::size_t other : {(i + kBins - 1) % kBins, (i + 1) % kBins})
      if (nearest[other] > 0.0F) smallest = std::min(smallest, nearest[other]);
    free_to_m_[i] = std::max(0.0F, smallest - kMarginM);
    farthest_free_m_ = std::max(farthest_free_m_, free_to_m_[i]);
  }
}

bool RangeProfile::sees_through(const Eigen::Vector2f& point) const {
  const Eigen::Vector2f ray = point - scanner_;
  const float squared = ray.squaredNorm();
  if (squared >= farthest_free_m_ * farthest_free_m_) return false;
  const float free_to_m = free_to_m_[bin_of(ray, kBins)];
  return squared < free_to_m * free_to_m;
}

double fraction_in_free_space(const RangeProfile& other, const ScanPoints& points,
                              const Pose2& other_T_base) {
  if (points.surface.empty()) return 0;
  const Transform move(other_T_base);
  const auto count =
      std::count_if(points.surface.begin(), points.surface.end(),
                    [&](const SurfacePoint& point) { return other.sees_through(move * point.position); });
  return static_cast<double>(count) / static_cast<double>(points.surface.size());
}

double fraction_seen_through(const RangeProfile& scan, const SurfaceMap& map, const Pose2& map_T_base,
                             double radius_m) {
  const Transform back(inverse(map_T_base));
  const auto radius = static_cast<float>(radius_m);
  int seen = 0;
  int contradicted = 0;
  const Eigen::Vector2f base(static_cast<float>(map_T_base.x), static_cast<float>(map_T_base.y));
  map.visit_about(base, radius, [&](const SurfaceMap::Surface& surface) {
    if (surface.weight < 2) return;
    const Eigen::Vector2f point = back * surface.mean;
    if (point.squaredNorm() > radius * radius) return;
    ++seen;
    if (scan.sees_through(point)) ++contradicted;
  });
  return seen == 0 ? 0.0 : static_cast<double>(contradicted) / seen;
}

}  // namespace extperfc::mapping
