#pragma once

#include <visualization_msgs/Marker.h>

#include "extperfc/world/shape.hpp"

namespace extperfc::ros_convert {

/// A shape at its own origin, to be added; name, frame, pose and colour are the caller's. Cones and meshes in
/// memory become triangles, other meshes refer to their files.
[[nodiscard]] visualization_msgs::Marker to_marker(const Geometry& geometry);

}  // namespace extperfc::ros_convert
