#pragma once

#include <cstddef>
#include <vector>

#include "extperfc/scan/ground.hpp"

#include "scan/columns.hpp"

namespace extperfc::scan {

/// Follows the floor of one column outwards from the target frame's origin, where it is at params.z_m. A
/// point belongs to it when it lies no higher than clearance_m above what the floor may have risen to since
/// its last point:
///  - never more than tan(max_slope_rad) * distance, and the floor itself only rises as steeply as that, so
///    walls are not climbed however fine their points lie;
///  - over a gap of more than 0.6 m, what the slope of the floor so far leads to, and as much again as over
///    0.6 m. Beyond some metres the rings of a lidar meet the floor so far from each other that a kerb and
///    the foot of a ramp look alike; then the point is an obstacle until the robot is nearer.
/// A point above clearance_m with another one steeply above or below it within 0.1 m is no floor: it is a
/// face.
///
/// Moves the obstacles to the column's front, in order; returns how many they are. `z` are heights in the
/// target frame [m], by the points' index. O(points of the column).
std::size_t obstacles_first(const Column& column, const std::vector<float>& z, const GroundParams& params);

}  // namespace extperfc::scan
