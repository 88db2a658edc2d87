#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "extperfc/base/rng.hpp"

#include "localize/beams.hpp"
#include "localize/map_model.hpp"
#include "localize/particle_set.hpp"

namespace extperfc::localize {

/// Poses on the whole map that explain a scan (sensor resetting, Lenser and Veloso 2000): particles for
/// global localization. Draws `tries` poses uniformly over the free space, selects some of them by a widened
/// likelihood field, jitters them and selects `count` with equal weights: half by the true field, half by
/// whole rays too, because the rays of a pose that is not refined graze walls.
///
/// Similar poses are all kept, in proportion to their fit, with the likelihood exponent limited so that a
/// quarter of the poses stays effective. O(tries * 30 + max(count, tries / 5) * beams). Uniform poses where
/// the scan has no end points.
[[nodiscard]] ParticleSet search_scan(const MapModel& map_model, const Beams& beams, std::size_t tries,
                                      std::size_t count, Rng& rng);

/// Uniform over free cells and headings, equal weights.
[[nodiscard]] ParticleSet draw_uniform(const FreeSpace& free_space, std::size_t count, Rng& rng);

/// The particles with the given numbers, in that order, with equal weights.
[[nodiscard]] ParticleSet pick(const ParticleSet& from, const std::vector<std::uint32_t>& numbers);

/// Puts the poses of `more` behind those of `particles`; the weights become invalid.
void append(ParticleSet& particles, const ParticleSet& more);

/// Adds normal noise to every particle.
void add_jitter(ParticleSet& particles, double sigma_m, double sigma_rad, Rng& rng);

}  // namespace extperfc::localize
