#pragma once

#include <cstdint>

#include "extperfc/simulate/world_spec.hpp"

namespace extperfc::simulate {

/// A room for difficult training images: cones, cubes and spheres of any look and in any orientation on a
/// table or the floor, leaning, piled or held, among look-alikes, hands and cables, in odd light. It is to be
/// looked at only: objects may touch or hang in the air.
[[nodiscard]] WorldSpec varied_world(std::uint64_t seed);

}  // namespace extperfc::simulate
