#pragma once

#include <cstddef>

namespace extperfc::localize {

/// The value that a standard normal variable stays below with `probability` in (0, 1). Error below 1e-8.
[[nodiscard]] double normal_quantile(double probability);

/// Particles so that with a probability of `quantile` standard deviations the distance (Kullback-Leibler)
/// between the distribution of the samples and the true one over `bins` bins is below `error` (Fox 2003,
/// equation 7, by Wilson and Hilferty's approximation of the chi-square quantile). 1 for a single bin.
[[nodiscard]] std::size_t kld_sample_size(std::size_t bins, double error, double quantile);

}  // namespace extperfc::localize
