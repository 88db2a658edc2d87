#pragma once

#include <optional>

#include <Eigen/Core>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

inline constexpr double kYieldM = 1.1;  ///< from the robot's middle to a person's path, where it is narrow
inline constexpr double kRoomyYieldM = 1.6;  ///< else: nobody needs to walk round it
inline constexpr double kYieldReachM = 5.0;  ///< along the robot's path

/// Where a robot stands so that a person can pass who stands before it. Where the person wants to go is not
/// known: the nearest pose with a free footprint, at most kYieldReachM away without passing the person,
/// where the robot is kRoomyYieldM from the straight line between the two, and from which who keeps so far
/// from it can go wherever one can go from where the robot is now: to 70 per cent of that, and to the half of
/// each corridor or room farther on. Without such a pose the same with kYieldM; without that the one that
/// leaves the largest part, if that is more than the half. Poses and points are in the grid's frame. No
/// value: the start is not in the grid, what is not finite, or there is no such place. O(n m) in the cells n
/// of 0.1 m within 8 m of the start and the places m that are tried.
[[nodiscard]] std::optional<Pose2> yield_place(const CostGrid& costs, const Footprint& footprint,
                                               const Pose2& start, const Eigen::Vector2d& person_m);

}  // namespace extperfc::navigate
