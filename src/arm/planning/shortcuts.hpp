#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/base/rng.hpp"

namespace extperfc::arm {

/// A gain below this is not worth a segment more.
inline constexpr double kMinGainRad = 1e-3;

/// Replaces the part of a path between two places, given by their distance from its start.
using Cut = std::function<void(std::vector<JointVector>* path, double from_rad, double to_rad)>;
/// Calls `cut` with random places, `rounds` times or until `stop` says so or two waypoints are left.
void cut_at_random(std::vector<JointVector>* path, int rounds, Rng& rng, const std::function<bool()>& stop,
                   const Cut& cut);

/// Puts `between` in the place of the waypoints behind `from` up to `to`.
void replace(std::vector<JointVector>* path, std::size_t from, std::size_t to,
             const std::vector<JointVector>& between);

/// A path no longer than `waypoints` with the same ends, every segment proven free if those of `waypoints`
/// are. First it leaves out waypoints, then it joins random places of the path, `rounds` times or until
/// `stop` says so.
[[nodiscard]] std::vector<JointVector> shorten(CollisionChecker& checker, std::vector<JointVector> waypoints,
                                               int rounds, Rng& rng, const std::function<bool()>& stop);

}  // namespace extperfc::arm
