#pragma once

#include <vector>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/world/pose.hpp"

#include "navigate/global/footprint_refiner.hpp"
#include "navigate/global/plan_clock.hpp"

namespace extperfc::navigate {

/// Free poses with the goal's yaw at most tolerance_m away, nearest first; the following ones are a quarter
/// of the tolerance apart from all before, so that they may lie on other sides of a wall.
[[nodiscard]] std::vector<Pose2> free_poses(const CostGrid& costs, const FootprintRefiner& footprint,
                                            const Pose2& goal, double tolerance_m, std::size_t max_count,
                                            const PlanClock& clock);

}  // namespace extperfc::navigate
