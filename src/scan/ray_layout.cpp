#include "scan/ray_layout.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "extperfc/base/arc_tangent.hpp"
#include "extperfc/base/math.hpp"

namespace extperfc::scan {

namespace {

/// A complete revolution: the ray after the last one would be the first again.
bool is_full_revolution(const ScanParams& params, double rays) {
  constexpr double kRoundingRad = 1e-6;
  return rays * params.angle_increment > kTwoPi - kRoundingRad;
}

/// Rays at angle_min + i * increment up to angle_max.
std::size_t count_rays(const ScanParams& params) {
  constexpr double kRounding = 1e-3;  // of an increment: angles come from text with few digits
  const double steps = std::floor((params.angle_max - params.angle_min) / params.angle_increment + kRounding);
  return static_cast<std::size_t>(is_full_revolution(params, steps) ? steps : steps + 1);
}

}  // namespace

RayLayout::RayLayout(const ScanParams& params)
    : angle_min_(params.angle_min),
      angle_increment_(params.angle_increment),
      count_(count_rays(params)),
      full_revolution_(is_full_revolution(params, static_cast<double>(count_))),
      bins_{static_cast<float>(std::remainder(params.angle_min - 0.5 * params.angle_increment, kTwoPi)),
            static_cast<float>(1.0 / params.angle_increment), static_cast<float>(count_)} {}

std::uint32_t RayLayout::Bins::bin_of(float x, float y) const {
  float from_edge = arc_tangent(y, x) - first_edge_rad;
  from_edge += from_edge < 0 ? kTwoPiF : 0.0F;
  from_edge -= from_edge >= kTwoPiF ? kTwoPiF : 0.0F;
  const float bin = from_edge * per_rad;
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(bin < none ? bin : none));
}

std::size_t RayLayout::ray_of(float x, float y) const {
  const std::size_t bin = bins_.bin_of(x, y);
  return full_revolution_ && bin == count_ ? 0 : bin;
}

void RayLayout::rays_of(const std::vector<float>& x, const std::vector<float>& y,
                        std::vector<std::uint32_t>& rays) const {
  rays.resize(x.size());
  const Bins bins = bins_;  // a copy, which the writes below cannot alias
  for (std::size_t i = 0; i < x.size(); ++i) rays[i] = bins.bin_of(x[i], y[i]);
  if (full_revolution_) std::replace(rays.begin(), rays.end(), static_cast<std::uint32_t>(count_), 0U);
}

std::size_t RayLayout::neighbour(std::size_t ray, int step) const {
  if (step < 0 && ray == 0) return full_revolution_ ? count_ - 1 : ray;
  if (step > 0 && ray + 1 == count_) return full_revolution_ ? 0 : ray;
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
