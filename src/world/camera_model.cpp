#include "extperfc/world/camera_model.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace extperfc {

namespace {

using Distortion = std::array<double, 5>;

Eigen::Vector2d distort(const Distortion& d, const Eigen::Vector2d& p) {
  const double r2 = p.squaredNorm();
  const double radial = 1.0 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]));
  const double xy2 = 2.0 * p.x() * p.y();
  return {p.x() * radial + d[2] * xy2 + d[3] * (r2 + 2.0 * p.x() * p.x()),
          p.y() * radial + d[2] * (r2 + 2.0 * p.y() * p.y()) + d[3] * xy2};
}

Eigen::Vector2d undistort(const Distortion& d, const Eigen::Vector2d& distorted) {
  constexpr int kMaxSteps = 20;
  constexpr double kTolerance = 1e-9;  // normalised units: a millionth of a pixel
  Eigen::Vector2d p = distorted;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Vector2d miss = distorted - distort(d, p);
    p += miss;
    if (miss.squaredNorm() < kTolerance * kTolerance) break;
  }
  return p;
}

bool is_zero(const Distortion& d) {
  return std::all_of(d.begin(), d.end(), [](double k) { return k == 0.0; });
}

}  // namespace

Result<void> CameraModel::validate() const {
  const auto bad = [](const std::string& what) {
    return fail(ErrorCode::kInvalidArgument, "camera model: " + what + "; is the camera calibrated?");
  };
  if (width <= 0 || height <= 0)
    return bad("image size " + std::to_string(width) + " x " + std::to_string(height) + " must be positive");
  if (!(std::isfinite(fx) && fx > 0.0 && std::isfinite(fy) && fy > 0.0))
    return bad("focal lengths fx = " + std::to_string(fx) + ", fy = " + std::to_string(fy) +
               " px must be positive and finite");
  if (!std::isfinite(cx) || !std::isfinite(cy)) return bad("principal point is not finite");
  if (!std::all_of(distortion.begin(), distortion.end(), [](double k) { return std::isfinite(k); }))
    return bad("a distortion coefficient is not finite");
  return {};
}

Eigen::Vector3d CameraModel::back_project(double u, double v, double z) const {
  Eigen::Vector2d p((u - cx) / fx, (v - cy) / fy);
  if (!is_zero(distortion)) p = undistort(distortion, p);
  return {p.x() * z, p.y() * z, z};
}

Eigen::Vector2d CameraModel::project(const Eigen::Vector3d& point) const {
  Eigen::Vector2d p = point.head<2>() / point.z();
  if (!is_zero(distortion)) p = distort(distortion, p);
  return {fx * p.x() + cx, fy * p.y() + cy};
}

}  // namespace extperfc
