#include "scan/ray_layout.hpp"

#include <cmath>
#include <limits>

namespace extperfc::scan {

namespace {

constexpr double kTurn = 2 * 3.14159265358979323846;

/// A turn that is complete: the ray after the last one would be the first again.
bool is_full_turn(const ScanParams& params, double rays) {
  constexpr double kRoundingRad = 1e-6;
  return rays * params.angle_increment > kTurn - kRoundingRad;
}

/// Rays at angle_min + i * increment up to angle_max.
std::size_t count_rays(const ScanParams& params) {
  constexpr double kRounding = 1e-3;  // of an increment: angles come from text with few digits
  const double steps = std::floor((params.angle_max - params.angle_min) / params.angle_increment + kRounding);
  return static_cast<std::size_t>(is_full_turn(params, steps) ? steps : steps + 1);
}

}  // namespace

RayLayout::RayLayout(const ScanParams& params)
    : angle_min_(params.angle_min),
      angle_increment_(params.angle_increment),
      count_(count_rays(params)),
      full_turn_(is_full_turn(params, static_cast<double>(count_))),
      rays_per_rad_(static_cast<float>(1.0 / params.angle_increment)),
      first_edge_rad_(static_cast<float>(params.angle_min - 0.5 * params.angle_increment)) {}

std::size_t RayLayout::ray_of(float x, float y) const {
  constexpr auto kTurnF = static_cast<float>(kTurn);
  float from_edge = std::atan2(y, x) - first_edge_rad_;
  while (from_edge < 0) from_edge += kTurnF;
  while (from_edge >= kTurnF) from_edge -= kTurnF;
  const auto ray = static_cast<std::size_t>(from_edge * rays_per_rad_);
  return full_turn_ && ray == count_ ? 0 : ray;
}

std::size_t RayLayout::beside(std::size_t ray, int step) const {
  if (step < 0 && ray == 0) return full_turn_ ? count_ - 1 : ray;
  if (step > 0 && ray + 1 == count_) return full_turn_ ? 0 : ray;
  return step < 0 ? ray - 1 : ray + 1;
}

void RayLayout::clear(PlanarScan& scan, bool with_intensity) const {
  scan.angle_min = angle_min_;
  scan.angle_increment = angle_increment_;
  scan.angle_max = angle_min_ + static_cast<double>(count_ - 1) * angle_increment_;
  scan.ranges.assign(count_, std::numeric_limits<float>::quiet_NaN());
  scan.intensities.assign(with_intensity ? count_ : 0, 0.0F);
}

}  // namespace extperfc::scan
