#pragma once

#include <cstdint>

/// Smooth noise for textures: values on a lattice that repeats, the same on every call. `layer` separates one
/// pattern from another.
namespace extperfc::simulate {

/// 0 at and below `low`, 1 at and above `high`, smooth between (Hermite's cubic). `low` and `high` differ.
[[nodiscard]] float smooth_step(float low, float high, float x);

/// Uniform value of a cell of a lattice, [0, 1).
[[nodiscard]] float cell(std::uint32_t layer, int x, int y);

/// Smooth noise on a lattice of `across` x `down` cells that repeats, [0, 1); x, y in [0, 1) are the whole
/// texture.
[[nodiscard]] float lattice(std::uint32_t layer, float x, float y, int across, int down);

/// Sum of `count` octaves of it, [0, 1).
[[nodiscard]] float octaves(std::uint32_t layer, float x, float y, int across, int down, int count);

}  // namespace extperfc::simulate
