#pragma once

#include <vector>

#include <Eigen/Core>

#include "extperfc/depth/object_fit.hpp"

namespace extperfc::depth {

/// A pixel with a measurement.
struct Point {
  Eigen::Vector3d position;  ///< optical frame [m]
  double sigma_m{0};         ///< standard deviation along the ray [m], rounding to 1 mm included
  bool in_box{false};        ///< of the detection, which is a little wider here
};

/// The point of the pixel (x, y) with the depth `z_m`.
[[nodiscard]] Point point_at(const CameraModel& camera, int x, int y, double z_m,
                             const StereoNoiseModel& noise);

struct Points {
  std::vector<Point> items;
  /// Independent measurements that a pixel counts for: neighbours share their errors. (0, 1]
  double independent{1};
};

/// Pixels in the box and around it, on a regular grid of at most about 4,000; those farther from `anchor`
/// than the box is wide and high there, twice, belong to something else and are left out.
[[nodiscard]] Points gather(const ImageView& depth, const CameraModel& camera, const Box2& box,
                            const Eigen::Vector3d& anchor, const ObjectFitParams& params);

}  // namespace extperfc::depth
