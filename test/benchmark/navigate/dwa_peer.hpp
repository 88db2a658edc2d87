#pragma once

#include <memory>

#include "extperfc/navigate/local_planner.hpp"

namespace extperfc::benchmark {

/// Peer: the dynamic window approach (Fox, Burgard and Thrun, "The dynamic window approach to collision
/// avoidance", IEEE Robotics and Automation Magazine 4(1), 1997) as dwa_local_planner rates it: constant
/// velocities of a window, rolled out for 1.7 s; costs of cells, distance to the path and to a local goal on
/// it; the exact footprint.
[[nodiscard]] std::unique_ptr<navigate::LocalPlanner> make_dwa(const navigate::VelocityLimits& limits,
                                                               navigate::BaseKind base);

}  // namespace extperfc::benchmark
