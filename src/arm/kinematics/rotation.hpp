#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

/// The rotation group's logarithm and its derivative; Sola, Deray, Atchuthan, "A micro Lie theory for state
/// estimation in robotics", 2018, appendix B.
namespace extperfc::arm {

/// Rotation vector [rad] with a norm in [0, pi].
[[nodiscard]] inline Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& r) {
  const Eigen::Vector3d twice(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));
  const double sine = 0.5 * twice.norm();
  const double cosine = 0.5 * (r.trace() - 1);
  if (sine > 1e-9) return twice * (std::atan2(sine, cosine) / (2 * sine));
  if (cosine > 0) return 0.5 * twice;  // next to none
  const Eigen::AngleAxisd half_rotation(r);
  return half_rotation.axis() * half_rotation.angle();
}

[[nodiscard]] inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d out;
  out << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return out;
}

/// Change of the rotation vector per small rotation in front of it: log(exp(d) exp(v)) = v + M d. |v| < 2 pi.
/// With -v, of one behind it: log(exp(v) exp(d)) = v + M(-v) d.
[[nodiscard]] inline Eigen::Matrix3d vector_change(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  const double half = 0.5 * angle;
  const double factor = angle < 1e-4 ? 1.0 / 12 : (1 - half / std::tan(half)) / (angle * angle);
  const Eigen::Matrix3d cross = cross_matrix(v);
  return Eigen::Matrix3d::Identity() - 0.5 * cross + factor * cross * cross;
}

}  // namespace extperfc::arm
