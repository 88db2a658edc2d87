#include "ros/simulate/body_extent.hpp"

#include <type_traits>
#include <variant>

namespace extperfc::ros_simulate {

namespace {

/// Half lengths of the box around a shape, in the shape's own frame.
Eigen::Vector3d half_size(const Geometry& geometry) {
  return std::visit(
      [](const auto& shape) -> Eigen::Vector3d {
        using Shape = std::decay_t<decltype(shape)>;
        if constexpr (std::is_same_v<Shape, Box>) {
          return 0.5 * shape.size_m;
        } else if constexpr (std::is_same_v<Shape, Cylinder>) {
          return {shape.radius_m, shape.radius_m, 0.5 * shape.length_m};
        } else if constexpr (std::is_same_v<Shape, Sphere>) {
          return Eigen::Vector3d::Constant(shape.radius_m);
        } else if constexpr (std::is_same_v<Shape, Cone>) {
          return {shape.radius_m, shape.radius_m, 0.5 * shape.height_m};
        } else {
          return 0.5 * shape.scale;
        }
      },
      geometry);
}

}  // namespace

Eigen::AlignedBox3d extent_of(const simulate::BodySpec& body) {
  Eigen::AlignedBox3d box;
  for (const auto& shape : body.shapes) {
    const Eigen::Vector3d half = half_size(shape.geometry);
    const Eigen::Vector3d reach = shape.body_T_shape.linear().cwiseAbs() * half;
    box.extend(Eigen::Vector3d(shape.body_T_shape.translation() - reach));
    box.extend(Eigen::Vector3d(shape.body_T_shape.translation() + reach));
  }
  return box;
}

}  // namespace extperfc::ros_simulate
