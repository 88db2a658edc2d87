#pragma once

#include <cmath>

#include <Eigen/Core>

namespace extperfc::mapping {

/// The matrix that rotates x, y, yaw by `yaw` [rad], for covariances and information.
[[nodiscard]] inline Eigen::Matrix3d rotation_by(double yaw) {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  rotation(0, 0) = rotation(1, 1) = std::cos(yaw);
  rotation(1, 0) = std::sin(yaw);
  rotation(0, 1) = -rotation(1, 0);
  return rotation;
}

}  // namespace extperfc::mapping
