#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/map/world_drive.hpp"

namespace extperfc::benchmark {

/// Names of the kinds of buildings that make_world() knows:
///   ring_twice     a rectangle of corridors, 40 m x 25 m to 160 m x 120 m, driven twice; 180 rays up to 8 m
///   sparse_ring    the same with a recess every 15 to 30 m
///   poor_scanner   a smaller one with 121 rays up to 5 m and 4 cm of noise
///   loop_then_end  once around and 2 to 14 m on: the loop has just been seen when the recording ends
///   eight          two loops that share a side, driven in both directions
///   grid           corridors in 2 or 3 by 2 meshes, a random path of 600 m
///   out_and_back   a corridor of 80 to 250 m and a branch, without a loop
///   desks          rooms that are all alike, with the same desks, then around almost twice
///   big_loop       340 to 700 m around before anything is seen again, and a corridor across
///   lobby          a corridor into a hall of 30 m x 20 m to 60 m x 40 m with a few pillars
[[nodiscard]] const std::vector<std::string>& world_kinds();

/// One more: a random path of 1,900 m through a grid of corridors, 35 to 108 m apart, that look alike.
/// Minutes of CPU a drive.
inline constexpr char kLongGrid[] = "long_grid";

/// A building of this kind. Random, by the seed: dimensions, how corridors look, the scanner (180 to 541
/// rays, up to 8, 30 or 80 m), odometry (up to 5 % and 0.03 rad/m off; with most kinds sometimes none), path
/// per scan, and with some kinds people and glass. The same on every run of one build. Errors: no such kind.
[[nodiscard]] Result<WorldCase> make_world(const std::string& kind, std::uint64_t seed);

}  // namespace extperfc::benchmark
