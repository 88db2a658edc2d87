#pragma once

#include <cstdint>

#include "extperfc/simulate/random_world.hpp"

namespace extperfc::simulate {

/// Rooms on both sides of a corridor; some neighbours are joined, so that there are loops.
[[nodiscard]] WorldSpec floor_world(const RandomWorldParams& params, std::uint64_t seed);

}  // namespace extperfc::simulate
