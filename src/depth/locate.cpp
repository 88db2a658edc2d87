#include <algorithm>
#include <cmath>

#include "extperfc/depth/box_depth.hpp"

#include "depth/box_error.hpp"

namespace extperfc::depth {

namespace {

/// The centre of an unknown shape lies between 1/4 and 3/4 of the extent behind its surface (cone to cube on
/// edge). A uniform distribution over that range has this standard deviation, as a part of the extent: 0.5 /
/// sqrt(12).
constexpr double kPushSigma = 0.144;

}  // namespace

Object3 locate(const CameraModel& camera, const Box2& box, const BoxDepth& depth) {
  const double z = depth.depth_m;
  const double u = 0.5 * (static_cast<double>(box.x_min) + box.x_max) - 0.5;  // edges to pixel centres
  const double v = 0.5 * (static_cast<double>(box.y_min) + box.y_max) - 0.5;
  const double width_px = std::abs(static_cast<double>(box.x_max) - box.x_min);
  const double height_px = std::abs(static_cast<double>(box.y_max) - box.y_min);

  Object3 object;
  object.surface = camera.back_project(u, v, z);
  const double width = width_px * z / camera.fx;
  const double height = height_px * z / camera.fy;
  object.size = {width, height, std::min(width, height)};
  const Eigen::Vector3d ray = object.surface.normalized();
  object.center = object.surface + 0.5 * object.size.z() * ray;

  // d surface / d depth is the ray scaled to unit depth; the push along the ray is independent of it.
  const Eigen::Vector3d by_depth = depth.sigma_m * (object.surface / z);
  const Eigen::Vector3d by_push = kPushSigma * object.size.z() * ray;
  const Eigen::Vector3d by_pixel(center_sigma_px(width_px) * z / camera.fx,
                                 center_sigma_px(height_px) * z / camera.fy, 0.0);
  object.covariance = by_depth * by_depth.transpose() + by_push * by_push.transpose();
  object.covariance += by_pixel.cwiseAbs2().asDiagonal();
  return object;
}

}  // namespace extperfc::depth
