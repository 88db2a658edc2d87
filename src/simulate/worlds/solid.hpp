#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "extperfc/world/shape.hpp"

/// Volumes, extents and outlines of shapes. Meshes count as the box that `scale` spans about their origin,
/// which worlds do not use.
namespace extperfc::simulate {

[[nodiscard]] double volume_m3(const Geometry& geometry);

/// Centre of mass of a body of uniform density, in the body's frame. At least one shape.
[[nodiscard]] Eigen::Vector3d centre_of_mass(const std::vector<Shape>& shapes);

/// Convex polygon, counter-clockwise, without repeated points.
using Polygon = std::vector<Eigen::Vector2d>;

/// Vertical shadow of the part of a shape between two heights; empty when it does not reach between them.
/// Boxes are exact; round shapes are polygons of 32 corners around the outline (at most 0.5 % too large).
[[nodiscard]] std::optional<Polygon> outline(const Geometry& geometry, const Pose& target_T_shape,
                                             double z_low_m, double z_high_m);

/// Whether two convex polygons share more than a border of `slack_m`.
[[nodiscard]] bool overlap(const Polygon& a, const Polygon& b, double slack_m);

/// Distance of a point from a convex polygon, 0 inside [m].
[[nodiscard]] double distance_m(const Polygon& polygon, const Eigen::Vector2d& point);

/// A box that lies within the shape, for overlaps that are beyond doubt. Full lengths of the edges, and its
/// centre in the shape's frame.
struct ShapeBox {
  Eigen::Vector3d half_m;
  Eigen::Vector3d centre_m;
};
[[nodiscard]] ShapeBox inner_box(const Geometry& geometry);
/// The smallest box around the shape, along the shape's axes.
[[nodiscard]] ShapeBox outer_box(const Geometry& geometry);

/// Depth by which two turned boxes overlap, along the axis of least overlap (separating axes); 0 or less:
/// apart [m].
[[nodiscard]] double box_overlap_m(const ShapeBox& a, const Pose& world_T_a, const ShapeBox& b,
                                   const Pose& world_T_b);

}  // namespace extperfc::simulate
