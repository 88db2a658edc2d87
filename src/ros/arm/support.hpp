#pragma once

#include <string>
#include <utility>
#include <vector>

#include "extperfc/arm/collision_world.hpp"
#include "extperfc/world/shape.hpp"

namespace extperfc::arm_node {

/// Lowest and highest z [m] of a shape at a pose, in the root's frame.
[[nodiscard]] std::pair<double, double> heights(const Geometry& geometry, const Pose& root_T_shape);
/// The same for an object of several shapes; infinity and -infinity without shapes.
[[nodiscard]] std::pair<double, double> heights(const std::vector<Shape>& shapes, const Pose& root_T_object);

/// Allows contact between the object, whose lower side is at `bottom_z_m`, and all objects that end there or
/// below: its support.
void allow_support(arm::CollisionWorld& world, const std::string& object, double bottom_z_m);

}  // namespace extperfc::arm_node
