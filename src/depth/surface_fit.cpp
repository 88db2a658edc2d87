#include "depth/surface_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "depth/cauchy.hpp"

namespace extperfc::depth {

namespace {

constexpr int kIterations = 4;
constexpr double kQuantum = 0.001 / 3.4641016151377544;  // sigma of rounding to 1 mm [m]: 1 mm / sqrt(12)

/// Inverse depth as an affine function of position, in units of the spatial scale.
using PlaneNumbers = Eigen::Vector3d;

struct WeightedPoint {
  Eigen::Vector3d basis;  // 1, u, v
  double q;               // inverse depth [1/m]
  double weight;          // by distance from the centre
};

struct WeightedPoints {
  std::array<WeightedPoint, Samples::kCapacity> items;
  std::size_t size{0};
  [[nodiscard]] const WeightedPoint* begin() const { return items.data(); }
  [[nodiscard]] const WeightedPoint* end() const { return items.data() + size; }
};

void select(const Samples& samples, const Layer& layer, double scale_px, WeightedPoints& out) {
  for (const auto& s : samples) {
    if (s.depth_m < layer.near_m || s.depth_m > layer.far_m) continue;
    const double u = s.dx / scale_px;
    const double v = s.dy / scale_px;
    const double near = 1.0 / (1.0 + u * u + v * v);
    out.items[out.size++] = {{1.0, u, v}, 1.0 / s.depth_m, near * near};
  }
}

struct PlaneSums {
  Eigen::Matrix3d normal{Eigen::Matrix3d::Zero()};
  Eigen::Vector3d right{Eigen::Vector3d::Zero()};
  double weight{0};
  double weight2{0};
  double residual2{0};
};

PlaneSums accumulate(const WeightedPoints& points, const PlaneNumbers& plane, double scale) {
  PlaneSums sums;
  for (const auto& p : points) {
    const double residual = p.q - plane.dot(p.basis);
    const double w = p.weight * cauchy(residual, scale);
    sums.normal += w * p.basis * p.basis.transpose();
    sums.right += (w * p.q) * p.basis;
    sums.weight += w;
    sums.weight2 += w * w;
    sums.residual2 += w * residual * residual;
  }
  return sums;
}

/// Weighted least squares. Slopes are drawn a little towards zero: where all samples lie on one side of the
/// centre they would be little more than noise, and the centre is extrapolated.
PlaneNumbers solve(const PlaneSums& sums) {
  constexpr double kRidge = 0.1;
  Eigen::Matrix3d normal = sums.normal;
  normal(1, 1) += kRidge * sums.weight;
  normal(2, 2) += kRidge * sums.weight;
  return normal.ldlt().solve(sums.right);
}

}  // namespace

SurfaceFit fit_surface(const Samples& samples, const Layer& layer, const BoxDepthParams& params) {
  const double scale_px = 0.5 * params.window_px;
  WeightedPoints points;
  select(samples, layer, scale_px, points);

  const double q_near = 1.0 / layer.near_m;
  const double q_far = 1.0 / layer.far_m;
  PlaneNumbers plane(0.5 * (q_near + q_far), 0.0, 0.0);
  const double rounding = kQuantum * plane[0] * plane[0];
  const double narrowest = 2.0 * std::hypot(params.noise.sigma_inverse_depth(), rounding);
  double scale = std::max(narrowest, 0.5 * (q_near - q_far));
  PlaneSums sums;
  for (int i = 0; i < kIterations; ++i) {
    sums = accumulate(points, plane, scale);
    plane = solve(sums);
    scale = std::max(narrowest, 0.5 * scale);
  }

  const double z = 1.0 / std::clamp(plane[0], q_far, q_near);
  const double by_q = z * z;  // |dz/dq|
  return {z, by_q * by_q * sums.residual2 / sums.weight, sums.weight * sums.weight / sums.weight2,
          -by_q * plane[1] / scale_px, -by_q * plane[2] / scale_px};
}

}  // namespace extperfc::depth
