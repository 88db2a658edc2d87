#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"

namespace extperfc::scan {

enum class GroundMethod {
  kNone,    ///< every point counts
  kHeight,  ///< the floor is level, at z_m
  kPlane,   ///< the floor is the plane that most points near z_m lie on (RANSAC), so slopes and a tilted
            ///< sensor are taken up
  kSlope,   ///< the floor is followed outwards, ray by ray, as long as it does not rise steeply: ramps belong
            ///< to it, steps do not (after the column-wise idea of Petrovskaya and Thrun 2009)
};

[[nodiscard]] Result<GroundMethod> ground_method_from_name(const std::string& name);  ///< none, height, plane
[[nodiscard]] const char* to_string(GroundMethod method);

/// How points of the floor are separated from obstacles.
struct GroundParams {
  GroundMethod method{GroundMethod::kHeight};
  double z_m{0.0};            ///< where the floor is in the target frame, [-10, 10]
  double clearance_m{0.05};   ///< points lower than this above the floor belong to it, [0, 1]
  double max_slope_rad{0.1};  ///< kPlane, kSlope: what is steeper is no floor, (0, 0.7]
  // The rest is for kPlane only.
  double band_m{0.3};       ///< points this far from z_m at most are looked at, (0, 2]
  double inlier_m{0.03};    ///< points this far from a plane at most lie on it, (0, 0.5]
  int max_iterations{100};  ///< planes that are tried, [1, 10000]
  int min_points{100};      ///< fewer points on the best plane give no floor, [3, 100000]
  std::uint32_t seed{1};    ///< of the planes that are tried
};

/// The floor in the target frame: height(p) = normal . p + offset.
struct Ground {
  Eigen::Vector3f normal{0, 0, 1};  ///< unit vector, upwards
  float offset{0};                  ///< [m]

  [[nodiscard]] float height(const Eigen::Vector3f& point) const { return normal.dot(point) + offset; }
  /// Angle between the floor and the frame's x-y plane [rad].
  [[nodiscard]] double slope_rad() const;
};

}  // namespace extperfc::scan
