#include "localize/kld.hpp"

#include <cmath>

#include "extperfc/base/math.hpp"

namespace extperfc::localize {

double normal_quantile(double probability) {
  // Newton's method on the distribution itself; its derivative is the density. Symmetric, so only one side.
  if (probability > 0.5) return -normal_quantile(1 - probability);
  constexpr int kMaxSteps = 60;
  double z = 0;
  for (int i = 0; i < kMaxSteps; ++i) {
    const double error = 0.5 * std::erfc(-z / std::sqrt(2.0)) - probability;
    const double density = std::exp(-z * z / 2) / std::sqrt(kTwoPi);
    const double step = error / density;
    z -= step;
    if (std::abs(step) < 1e-12) break;
  }
  return z;
}

std::size_t kld_sample_size(std::size_t bins, double error, double quantile) {
  if (bins < 2) return 1;
  const double degrees = static_cast<double>(bins - 1);
  const double a = 2 / (9 * degrees);
  const double root = 1 - a + std::sqrt(a) * quantile;
  return static_cast<std::size_t>(std::ceil(degrees / (2 * error) * root * root * root));
}

}  // namespace extperfc::localize
