#pragma once

#include <Eigen/Core>

#include "extperfc/world/pose.hpp"
#include "extperfc/world/shape.hpp"

namespace extperfc::arm {

/// A box that stands upright: one of its edges is along the world's z axis, which points up.
struct UprightBox {
  Eigen::Vector3d position_m{Eigen::Vector3d::Zero()};  ///< of its centre
  double yaw_rad{0};                                    ///< of its x axis about the world's z
  Eigen::Vector3d size_m{Eigen::Vector3d::Zero()};      ///< along its own axes; z is the height
};

[[nodiscard]] Pose pose_of(const UprightBox& box);

/// The box without its tilt: the axis that is nearest to the vertical becomes z, so a box along a camera's
/// axes, whose height may be its y, gets its height in z. A box that is upright already keeps pose and size.
[[nodiscard]] UprightBox make_upright(const Pose& world_T_box, const Eigen::Vector3d& size_m);

/// Shape inside an upright box.
enum class UprightKind { kBox, kSphere, kCylinder, kCone };

/// The shape in an upright box, in the box's frame: a sphere as wide as the longest edge, a cylinder or cone
/// as wide as the longer level edge and as high as the box.
[[nodiscard]] Geometry shape_in(UprightKind kind, const Eigen::Vector3d& size_m);

/// True when only the position matters, because the shape is rotationally symmetric.
[[nodiscard]] inline bool is_round(UprightKind kind) {
  return kind != UprightKind::kBox;
}

}  // namespace extperfc::arm
