#include "localize/weights.hpp"

#include <algorithm>
#include <cmath>

#include "localize/kld.hpp"

namespace extperfc::localize {

namespace {

float largest(const std::vector<float>& logs) {
  return logs.empty() ? 0 : *std::max_element(logs.begin(), logs.end());
}

/// Of the weights after reweight(), without changing them.
double effective_after(const std::vector<float>& weights, const std::vector<float>& logs, float best,
                       double likelihood_exponent) {
  const auto k = static_cast<float>(likelihood_exponent);
  double sum = 0;
  double squares = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double w = weights[i] * std::exp(k * (logs[i] - best));
    sum += w;
    squares += w * w;
  }
  return squares > 0 ? sum * sum / squares : 0;
}

}  // namespace

double effective_count(const std::vector<float>& weights) {
  double squares = 0;
  for (const float w : weights) squares += double{w} * w;
  return squares > 0 ? 1 / squares : 0;
}

void reweight(std::vector<float>& weights, const std::vector<float>& logs, double likelihood_exponent) {
  const float best = largest(logs);
  const auto k = static_cast<float>(likelihood_exponent);
  double sum = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    weights[i] *= std::exp(k * (logs[i] - best));
    sum += weights[i];
  }
  if (!(sum > 0)) {  // the best particles had no weight left: use the scan alone
    for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] = std::exp(k * (logs[i] - best));
  }
  const auto scale = static_cast<float>(1 / sum);
  for (float& w : weights) w *= scale;
}

double tempered_exponent(const std::vector<float>& weights, const std::vector<float>& logs,
                         double max_exponent, double min_effective) {
  const float best = largest(logs);
  if (effective_after(weights, logs, best, max_exponent) >= min_effective) return max_exponent;
  constexpr int kSteps = 8;
  double low = std::log(max_exponent / 1000);
  double high = std::log(max_exponent);
  for (int i = 0; i < kSteps; ++i) {
    const double middle = (low + high) / 2;
    (effective_after(weights, logs, best, std::exp(middle)) >= min_effective ? low : high) = middle;
  }
  return std::exp(low);
}

std::vector<std::uint32_t> sample_systematic(const std::vector<float>& weights, std::size_t count, Rng& rng) {
  std::vector<std::uint32_t> drawn;
  drawn.reserve(count);
  double total = 0;
  for (const float w : weights) total += w;
  const double step = total / static_cast<double>(count);
  double next = rng.uniform(0, step);
  double sum = 0;
  for (std::uint32_t i = 0; i < weights.size(); ++i) {
    sum += weights[i];
    for (; drawn.size() < count && next < sum; next += step) drawn.push_back(i);
  }
  while (drawn.size() < count) drawn.push_back(static_cast<std::uint32_t>(weights.size() - 1));  // rounding
  return drawn;
}

std::size_t kld_count(const std::vector<float>& weights, const std::vector<std::uint32_t>& bin_of,
                      std::size_t bins, std::size_t min_count, std::size_t max_count, double error,
                      double quantile, Rng& rng) {
  if (min_count >= max_count) return max_count;
  std::vector<double> sums(weights.size());
  double sum = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) sums[i] = sum += weights[i];
  std::vector<bool> met(bins, false);
  std::size_t met_count = 0;
  std::size_t needed = min_count;
  for (std::size_t drawn = 0; drawn < std::min(needed, max_count); ++drawn) {
    const auto at = std::upper_bound(sums.begin(), sums.end(), rng.uniform(0, sum)) - sums.begin();
    const std::uint32_t bin = bin_of[std::min(static_cast<std::size_t>(at), weights.size() - 1)];
    if (met[bin]) continue;
    met[bin] = true;
    needed = std::max(min_count, kld_sample_size(++met_count, error, quantile));
  }
  return std::min(needed, max_count);
}

}  // namespace extperfc::localize
