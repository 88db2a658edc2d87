#pragma once

#include <vector>

#include <Eigen/Core>

#include "arm/collision/convex_part.hpp"

namespace extperfc::arm {

/// Convex hull of points, about the middle of its bounding box (body_T_part moves it back). Every given point
/// satisfies every plane: offsets are taken from the points, so a plane errs outwards. Errors: fewer than
/// four points, a hull thinner than 0.1 mm. O(n log n).
[[nodiscard]] Result<ConvexPart> convex_hull(const std::vector<Eigen::Vector3d>& points);

}  // namespace extperfc::arm
