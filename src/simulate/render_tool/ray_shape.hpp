#pragma once

#include <Eigen/Core>

#include "extperfc/world/shape.hpp"

namespace extperfc::simulate {

/// A half line; the direction need not have unit length.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
};

/// Whether the ray, given in the shape's frame, meets the shape. Meshes are never met.
[[nodiscard]] bool meets(const Ray& ray, const Geometry& geometry);

/// Radius of a sphere around the shape's origin that holds the shape [m].
[[nodiscard]] double bounding_radius_m(const Geometry& geometry);

}  // namespace extperfc::simulate
