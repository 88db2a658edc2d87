#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "extperfc/base/rng.hpp"

#include "localize/beams.hpp"
#include "localize/particle_set.hpp"
#include "localize/place.hpp"

namespace extperfc::localize {

/// Poses that explain a scan, wherever they lie on the map (sensor resetting, Lenser and Veloso 2000):
/// particles for a robot that does not know where it is. Draws `tries` poses all over the free space, keeps a
/// part of them by a widened likelihood field, moves each a little and keeps `count` by the true one, with
/// equal weights.
///
/// Places that look alike are all kept, in proportion to how well they fit, with the sharpness limited so
/// that a quarter of the poses count. O(tries * 30 + max(count, tries / 5) * beams). Uniform poses where the
/// scan has no end points.
[[nodiscard]] ParticleSet search_scan(const Place& place, const Beams& beams, std::size_t tries,
                                      std::size_t count, Rng& rng);

/// Uniform over free cells and headings, equal weights.
[[nodiscard]] ParticleSet draw_uniform(const FreeSpace& free_space, std::size_t count, Rng& rng);

/// The particles with the given numbers, in that order, with equal weights.
[[nodiscard]] ParticleSet pick(const ParticleSet& from, const std::vector<std::uint32_t>& numbers);

/// Adds normal noise to every particle.
void shake(ParticleSet& particles, double sigma_m, double sigma_rad, Rng& rng);

}  // namespace extperfc::localize
