#pragma once

#include <functional>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/base/rng.hpp"

namespace extperfc::arm::planning {

/// A path no longer than `waypoints` with the same ends, every segment proven free if those of `waypoints`
/// are. First it leaves out waypoints, then it joins random places of the path, `rounds` times or until
/// `stop` says so.
[[nodiscard]] std::vector<JointVector> shorten(CollisionChecker& checker, std::vector<JointVector> waypoints,
                                               int rounds, Rng& rng, const std::function<bool()>& stop);

}  // namespace extperfc::arm::planning
