#pragma once

#include <functional>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// Whether a cell of these costs is an obstacle.
using BlockedCosts = std::function<bool(Cost)>;

/// The line along which a narrow place is widest: among lines through its neighbourhood, rotated by at most
/// 0.6 rad from the pose's heading, the one with the widest strip beside it that holds no middle of a blocked
/// cell, `reach_m` before and behind the pose. Given as the point beside the pose in the middle of the strip,
/// heading along it. A door's leaf and its far jamb make a passage of another direction than the wall's.
/// @param within a pose in the narrow place whose position is free
/// @param reach_m [0.1, 5]
[[nodiscard]] Pose2 widest_line(const CostGrid& costs, const BlockedCosts& is_blocked, const Pose2& within,
                                double reach_m);

}  // namespace extperfc::navigate
