#include "depth/object_fit/support_plane.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "extperfc/base/rng.hpp"

namespace extperfc::depth {
namespace {

constexpr int kRounds = 80;
constexpr double kInlier = 3.0;            // standard deviations
constexpr double kMaxTiltSigmas = 3.0;     // of the normal against `up`
constexpr double kFlatRoughness = 0.0005;  // of a surface that is called flat [m]
constexpr int kRefinements = 3;
constexpr double kMinFraction = 0.1;  // of the pixels around the box that the support must hold

/// n . p = offset
struct Plane {
  Eigen::Vector3d normal;
  double offset{0};
  [[nodiscard]] double height(const Eigen::Vector3d& point) const { return normal.dot(point) - offset; }
};

/// Standard deviation of a point's height over a plane [m].
double height_sigma(const Point& point, const Eigen::Vector3d& normal) {
  return std::hypot(point.sigma_m * normal.dot(point.position.normalized()), kFlatRoughness);
}

bool lies_on(const Plane& plane, const Point& point) {
  return std::abs(plane.height(point.position)) < kInlier * height_sigma(point, plane.normal);
}

int count_on(const Plane& plane, const std::vector<Point>& ring) {
  return static_cast<int>(
      std::count_if(ring.begin(), ring.end(), [&](const Point& point) { return lies_on(plane, point); }));
}

std::optional<Plane> plane_through(const Point& a, const Point& b, const Point& c, const Eigen::Vector3d& up,
                                   double max_tilt) {
  Eigen::Vector3d normal = (b.position - a.position).cross(c.position - a.position);
  if (normal.norm() < 1e-9) return std::nullopt;
  normal.normalize();
  if (normal.dot(up) < 0) normal = -normal;
  // Three near points say little about a tilt: what they say is drawn to what is allowed.
  const double tilt = std::acos(std::min(1.0, normal.dot(up)));
  if (tilt > max_tilt) normal = up;
  return Plane{normal, normal.dot(a.position)};
}

std::optional<Plane> search(const std::vector<Point>& ring, const Eigen::Vector3d& up,
                            const ObjectFitParams& params) {
  Rng rng(params.seed);
  const int last = static_cast<int>(ring.size()) - 1;
  std::optional<Plane> best;
  int max_inliers = std::max(params.min_support_px, static_cast<int>(kMinFraction * (last + 1))) - 1;
  for (int round = 0; round < kRounds; ++round) {
    const auto plane = plane_through(ring[rng.integer(0, last)], ring[rng.integer(0, last)],
                                     ring[rng.integer(0, last)], up, kMaxTiltSigmas * params.tilt_sigma_rad);
    if (!plane) continue;
    const int on = count_on(*plane, ring);
    if (on <= max_inliers) continue;
    max_inliers = on;
    best = plane;
  }
  return best;
}

/// Least squares of the heights over up's plane through `origin`, with the tilt known to tilt_sigma_rad.
Eigen::Matrix3d refine(Plane& plane, const std::vector<Point>& ring, const Eigen::Vector3d& up,
                       const Eigen::Vector3d& origin, double independent, double tilt_sigma) {
  const Eigen::Vector3d e1 = up.unitOrthogonal();
  const Eigen::Vector3d e2 = up.cross(e1);
  Eigen::Matrix3d normal = Eigen::Vector3d(0, 1, 1).asDiagonal();
  normal /= tilt_sigma * tilt_sigma;
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Point& point : ring) {
    if (!lies_on(plane, point)) continue;
    const double sigma = height_sigma(point, plane.normal);
    const Eigen::Vector3d from = point.position - origin;
    const Eigen::Vector3d row(1, e1.dot(from), e2.dot(from));
    const double weight = independent / (sigma * sigma);
    normal += weight * row * row.transpose();
    right += weight * up.dot(from) * row;
  }
  const Eigen::Vector3d found = normal.ldlt().solve(right);  // height at the origin, slopes
  plane.normal = (up - found[1] * e1 - found[2] * e2).normalized();
  plane.offset = plane.normal.dot(origin + found[0] * up);
  return normal.inverse();
}

Pose frame_of(const Plane& plane, const Eigen::Vector3d& anchor) {
  Pose frame = Pose::Identity();
  frame.translation() = anchor - plane.height(anchor) * plane.normal;
  const Eigen::Vector3d away = anchor - plane.normal.dot(anchor) * plane.normal;
  const Eigen::Vector3d x = away.norm() > 1e-6 ? away.normalized() : plane.normal.unitOrthogonal();
  frame.linear() << x, plane.normal.cross(x), plane.normal;
  return frame;
}

}  // namespace

std::optional<SupportPlane> find_support(const Points& points, const Eigen::Vector3d& up,
                                         const Eigen::Vector3d& anchor, const ObjectFitParams& params) {
  std::vector<Point> ring;
  for (const Point& point : points.items)
    if (!point.in_box) ring.push_back(point);
  if (static_cast<int>(ring.size()) < params.min_support_px) return std::nullopt;
  auto plane = search(ring, up, params);
  if (!plane) return std::nullopt;
  Eigen::Matrix3d covariance;
  for (int i = 0; i < kRefinements; ++i) {
    const Eigen::Vector3d under = anchor - plane->height(anchor) * plane->normal;
    covariance = refine(*plane, ring, up, under, points.independent, params.tilt_sigma_rad);
  }
  SupportPlane support;
  support.camera_T_plane = frame_of(*plane, anchor);
  const double shared = params.noise.common_fraction * std::pow(params.noise.sigma(anchor.z()), 2);
  support.height_sigma_m = std::sqrt(covariance(0, 0) + shared);
  support.pixels = count_on(*plane, ring);
  if (support.pixels < params.min_support_px) return std::nullopt;
  return support;
}

bool rises(const SupportPlane& support, const Point& point) {
  constexpr double kStandsOut = 4.0;  // standard deviations of the height
  constexpr double kMinRise = 0.002;  // [m]
  const Eigen::Vector3d normal = support.camera_T_plane.linear().col(2);
  const double height = normal.dot(point.position - support.camera_T_plane.translation());
  const double sigma = point.sigma_m * std::abs(normal.dot(point.position.normalized()));
  return height >= std::max(kMinRise, kStandsOut * sigma);
}

}  // namespace extperfc::depth
