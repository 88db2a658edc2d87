#pragma once

#include <vector>

#include "arm/collision/convex_part.hpp"

namespace extperfc::arm {

/// Balls, in the part's frame, whose union holds the part.
///
/// The part's bounding box (for a cylinder: the cylinder itself, cut across its axis) is cut into equal cells
/// and each cell gets the ball about it; cells that a face of the part shuts out are left out. So the union
/// holds the part for all roundings. `excess_m` > 0 bounds how far a ball stands out at the sides;
/// where a row of balls ends, it stands out further by up to the half width of a cell.
[[nodiscard]] std::vector<Ball> sphere_cover(const ConvexPart& part, double excess_m);

}  // namespace extperfc::arm
