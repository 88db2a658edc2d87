#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace extperfc {

/// Value at `fraction` in [0, 1] of the sorted samples (nearest rank); NaN when there are none. O(n),
/// reorders `samples`.
[[nodiscard]] inline double percentile(std::vector<double>& samples, double fraction) {
  if (samples.empty()) return std::nan("");
  const std::ptrdiff_t rank =
      std::lround(std::clamp(fraction, 0.0, 1.0) * static_cast<double>(samples.size() - 1));
  std::nth_element(samples.begin(), samples.begin() + rank, samples.end());
  return samples[static_cast<std::size_t>(rank)];
}

}  // namespace extperfc
