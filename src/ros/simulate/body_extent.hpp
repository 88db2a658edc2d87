#pragma once

#include <Eigen/Geometry>

#include "extperfc/simulate/world_spec.hpp"

namespace extperfc::ros_simulate {

/// The box that encloses a body's shapes, along the axes of the body's own frame [m]. Empty for a body
/// without shapes; a mesh counts as the cube of 1 m that its scale stretches.
[[nodiscard]] Eigen::AlignedBox3d extent_of(const simulate::BodySpec& body);

}  // namespace extperfc::ros_simulate
