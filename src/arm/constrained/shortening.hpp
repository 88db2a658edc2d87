#pragma once

#include <functional>

#include "extperfc/base/rng.hpp"

#include "arm/constrained/manifold.hpp"

namespace extperfc::arm {

/// A path no longer than `waypoints` with the same ends, every piece within the tolerance and proven free if
/// those of `waypoints` are: joins random waypoints along the manifold, `rounds` times or until `stop` says
/// so, then leaves out waypoints that straight pieces do not need. `rounds` 0 changes nothing.
[[nodiscard]] States shorten(Manifold& manifold, States waypoints, int rounds, Rng& rng,
                             const std::function<bool()>& stop);

}  // namespace extperfc::arm
