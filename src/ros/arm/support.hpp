#pragma once

#include <string>
#include <utility>
#include <vector>

#include "extperfc/arm/collision_world.hpp"
#include "extperfc/world/shape.hpp"

namespace extperfc::arm_node {

/// Lowest and highest z [m] of a shape at a pose, in the root's frame.
[[nodiscard]] std::pair<double, double> heights(const Geometry& geometry, const Pose& root_T_shape);
/// The same of a thing of several shapes; infinity and -infinity without any.
[[nodiscard]] std::pair<double, double> heights(const std::vector<Shape>& shapes, const Pose& root_T_object);

/// Lets the thing, whose lower side is at `bottom_z_m`, touch what ends there or below: what it stands on.
void allow_support(arm::CollisionWorld& world, const std::string& thing, double bottom_z_m);

}  // namespace extperfc::arm_node
