#pragma once

#include <vector>

#include "extperfc/arm/collision_model.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/shape.hpp"

namespace extperfc::arm {

/// For each shape, whether the robot reaches into it: whether a point of a grid over the shape is in one of
/// the robot's collision shapes at `positions`. Such an object
/// cannot be there: the detection shows the robot itself, or an object that the robot partly hides. `shapes`
/// are boxes, spheres, cylinders and cones in the root's frame (body_T_shape as root_T_shape); others, and
/// those that are too small or not finite, are not reached into. The grid has a step of 5 mm, or a sixteenth
/// of the shape's bounding box where that is more; thinner overlaps may be missed. O(shapes x parts of the
/// robot near them).
[[nodiscard]] std::vector<bool> robot_overlaps(const CollisionModel& model, const JointVector& positions,
                                               const std::vector<Shape>& shapes);

}  // namespace extperfc::arm
