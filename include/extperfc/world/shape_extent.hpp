#pragma once

#include <vector>

#include "extperfc/world/shape.hpp"

namespace extperfc {

struct VerticalExtent {
  double low_m{0};
  double high_m{0};
};

/// Lowest and highest z of a shape, in the frame of its pose. Exact; a mesh that is not in memory counts as
/// the box that its scale spans about its origin. O(triangles) for meshes.
[[nodiscard]] VerticalExtent vertical_extent(const Geometry& geometry, const Pose& target_T_shape);
/// The same for a body of several shapes; infinity and -infinity without shapes.
[[nodiscard]] VerticalExtent vertical_extent(const std::vector<Shape>& shapes, const Pose& target_T_body);

}  // namespace extperfc
