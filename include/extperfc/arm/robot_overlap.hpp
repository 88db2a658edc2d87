#pragma once

#include <vector>

#include "extperfc/arm/collision_model.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/shape.hpp"

namespace extperfc::arm {

/// For each shape: true when the robot reaches into it, i.e. when a point of a grid over the shape is in one
/// of the robot's collision shapes at `positions`. Such an object cannot be there: the detection shows the
/// robot itself, or an object that the robot partly hides. `shapes` are boxes, spheres, cylinders and cones
/// in the root's frame (body_T_shape as root_T_shape); the result is false for others, and for those that are
/// too small or not finite. The grid has a step of 5 mm, or a sixteenth of the shape's bounding box if that
/// is more; thinner overlaps may be missed. O(shapes x parts of the robot near them).
[[nodiscard]] std::vector<bool> robot_overlaps(const CollisionModel& model, const JointVector& positions,
                                               const std::vector<Shape>& shapes);

}  // namespace extperfc::arm
