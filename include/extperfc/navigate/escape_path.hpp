#pragma once

#include <optional>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/path.hpp"
#include "extperfc/navigate/velocity.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// How a base gets away that touches an obstacle a little, as the grid has it: beside a wall, cells and
/// localization are a few centimetres off. The shortest straight motion (a differential base: along its
/// heading, or rotating on the spot) of at most 0.4 m to a pose where the whole footprint is free, which
/// nowhere comes deeper into obstacles than the start. No value: the start is deeper than 0.12 m in an
/// obstacle, or there is no such motion. Poses from the start on, at most 0.025 m and 0.05 rad apart.
[[nodiscard]] std::optional<Path> escape_path(const CostGrid& costs, const Footprint& footprint,
                                              const Pose2& start, BaseKind base);

}  // namespace extperfc::navigate
