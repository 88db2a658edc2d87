#pragma once

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/joint_trajectory.hpp"

namespace extperfc::arm {

/// Proof that the cubic Hermite spline between two points, which a controller follows, is free of collisions.
///
/// As a Bezier curve it stays within 3/4 of the distance of its inner control points from the chord between
/// its ends, which CollisionChecker::motion_free() proves with that deviation. Parts whose proof fails are
/// halved in time, which quarters their deviation, up to kMaxDepth times.
///
/// Returns the largest fraction of the interval's time in [begin, 1], counted from `begin`, that is proven; 1
/// when all of it is. `begin` in [0, 1]; `a` comes before `b`.
[[nodiscard]] double proven_fraction(CollisionChecker& checker, const TrajectoryPoint& a,
                                     const TrajectoryPoint& b, double begin = 0);

}  // namespace extperfc::arm
