#pragma once

#include <array>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"

namespace extperfc {

/// Pinhole camera with the five-coefficient "plumb bob" lens model (Brown 1966; k1 k2 p1 p2 k3), optical
/// frame of REP 103: x right, y down, z forward. Pixel (0, 0) is the CENTRE of the top-left pixel.
struct CameraModel {
  int width{0};                        ///< pixels
  int height{0};                       ///< pixels
  double fx{0};                        ///< pixels
  double fy{0};                        ///< pixels
  double cx{0};                        ///< pixels
  double cy{0};                        ///< pixels
  std::array<double, 5> distortion{};  ///< all zero for a rectified image

  /// An error that names the first value that cannot be (sizes and focal lengths must be positive and
  /// finite).
  [[nodiscard]] Result<void> validate() const;

  /// Point with depth `z` [m, along the optical axis] behind pixel (u, v), optical frame [m]. Undistorts by
  /// fixed-point iteration (converges for the mild distortion of RGB-D cameras; at most 20 steps).
  [[nodiscard]] Eigen::Vector3d back_project(double u, double v, double z) const;

  /// Pixel of a point in front of the camera (z > 0) [m], distortion applied.
  [[nodiscard]] Eigen::Vector2d project(const Eigen::Vector3d& point) const;
};

}  // namespace extperfc
