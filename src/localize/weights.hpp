#pragma once

#include <cstdint>
#include <vector>

#include "extperfc/base/rng.hpp"

namespace extperfc::localize {

/// 1 / (sum of squares) of weights that sum to one: between 1 and their number.
[[nodiscard]] double effective_count(const std::vector<float>& weights);

/// Multiplies the weights by exp(likelihood_exponent * log) and normalizes them, without overflow or
/// underflow.
void reweight(std::vector<float>& weights, const std::vector<float>& logs, double likelihood_exponent);

/// Tempering: the largest likelihood exponent up to `max_exponent` that leaves `min_effective` particles
/// effective, where there is one above `max_exponent` / 1000. Few particles over a wide area miss the narrow
/// peak of the likelihood: the one that happens to lie nearest to some peak would take all the weight,
/// whichever peak is the right one.
[[nodiscard]] double tempered_exponent(const std::vector<float>& weights, const std::vector<float>& logs,
                                       double max_exponent, double min_effective);

/// Low-variance sampling (Probabilistic Robotics, table 4.4): `count` numbers of particles in ascending
/// order, each particle within one of count * weight times.
[[nodiscard]] std::vector<std::uint32_t> sample_systematic(const std::vector<float>& weights,
                                                           std::size_t count, Rng& rng);

/// Particles that the distribution needs: draws bins one by one by their particles' weights until the number
/// of draws reaches the KLD bound for the bins met so far (Probabilistic Robotics, table 8.4); within
/// [min_count, max_count].
[[nodiscard]] std::size_t kld_count(const std::vector<float>& weights,
                                    const std::vector<std::uint32_t>& bin_of, std::size_t bins,
                                    std::size_t min_count, std::size_t max_count, double error,
                                    double quantile, Rng& rng);

}  // namespace extperfc::localize
