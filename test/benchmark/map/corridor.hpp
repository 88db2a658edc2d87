#pragma once

#include <Eigen/Core>

#include "extperfc/base/rng.hpp"

#include "test/benchmark/map/floor_world.hpp"

namespace extperfc::benchmark {

/// What the sides of a corridor look like: recesses, as closed doors leave them, rooms behind open ones, and
/// pillars at the wall.
struct CorridorLook {
  double width_m{2.2};          ///< of the corridor
  double spacing_m{8};          ///< between recesses
  double jitter{0.35};          ///< of the spacing, as a fraction of it
  double depth_m{0.2};          ///< of a recess
  double door_m{1.1};           ///< width of a recess
  bool regular{false};          ///< all recesses are alike and evenly spaced
  double room_fraction{0};      ///< of the recesses, which are open doors
  double pillar_fraction{0.1};  ///< of the recesses, which have a pillar beside them
};

enum class CorridorKind {
  kCommon,  ///< a recess every 4 to 12 m
  kSparse,  ///< every 15 to 30 m: few features
  kAlike,   ///< every 2.5 to 5 m, all alike
};

/// A random look; the width is kept.
[[nodiscard]] CorridorLook random_look(CorridorKind kind, double width_m, Rng& rng);

/// A straight corridor between two places [m] on a line along x or y. It reaches half its width beyond them,
/// so that corridors which share an end make a corner.
void add_corridor(FloorWorld& floor, const Eigen::Vector2d& start, const Eigen::Vector2d& end,
                  const CorridorLook& look, Rng& rng);

}  // namespace extperfc::benchmark
