#include "extperfc/arm/upright_box.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::arm {

Pose pose_of(const UprightBox& box) {
  return make_pose(box.position_m, {0.0, 0.0, box.yaw_rad});
}

UprightBox make_upright(const Pose& world_T_box, const Eigen::Vector3d& size_m) {
  const Eigen::Matrix3d axes = world_T_box.linear();
  Eigen::Index up = 0;
  axes.row(2).cwiseAbs().maxCoeff(&up);
  if (axes(2, 2) == axes.row(2).cwiseAbs().maxCoeff()) up = 2;
  const Eigen::Index x = (up + 1) % 3;
  const Eigen::Index y = (up + 2) % 3;
  // The x axis is never the steepest of the three, so its level part is 0.7 of it or more. Where the vertical
  // axis points down, y is reversed with it, which changes no size.
  return {world_T_box.translation(), std::atan2(axes(1, x), axes(0, x)), {size_m[x], size_m[y], size_m[up]}};
}

Geometry shape_in(UprightKind kind, const Eigen::Vector3d& size_m) {
  const double radius_m = 0.5 * std::max(size_m.x(), size_m.y());
  switch (kind) {
    case UprightKind::kSphere:
      return Sphere{0.5 * size_m.maxCoeff()};
    case UprightKind::kCylinder:
      return Cylinder{radius_m, size_m.z()};
    case UprightKind::kCone:
      return Cone{radius_m, size_m.z()};
    case UprightKind::kBox:
      break;
  }
  return Box{size_m};
}

}  // namespace extperfc::arm
