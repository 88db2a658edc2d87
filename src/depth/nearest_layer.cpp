#include "depth/nearest_layer.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace extperfc::depth {

namespace {

constexpr int kBins = 512;
constexpr double kRelativeWidth = 0.02;  // of a bin where noise does not matter: slant and shape of an object
constexpr double kNoiseWidth = 2.0;      // of a bin where noise rules, in standard deviations
constexpr float kMinShare = 0.15F;       // of all samples in a mode; less is a flying pixel or an edge
constexpr float kEdgeShare = 0.15F;      // of the mode's height, down to which its slopes belong to it

/// Depth axis on which a bin is `width(z) = kRelativeWidth * z + kNoiseWidth * sigma(z)` wide everywhere.
/// With sigma(z) = c z^2 the position is the closed integral of dz / width(z).
class Axis {
 public:
  Axis(const StereoNoiseModel& noise, float nearest_m)
      : c_(static_cast<float>(kNoiseWidth * noise.sigma_inverse_depth())), origin_(position(nearest_m)) {}

  [[nodiscard]] int bin(float z) const {
    return std::clamp(static_cast<int>(position(z) - origin_), 0, kBins - 1);
  }

 private:
  [[nodiscard]] float position(float z) const {
    constexpr auto kR = static_cast<float>(kRelativeWidth);
    return std::log(z / (kR + c_ * z)) / kR;
  }
  float c_;
  float origin_;
};

using Histogram = std::array<float, kBins>;

/// Nearest bin that is a local maximum and, with its two neighbours, holds the minimum share; else the
/// largest.
int find_mode(const Histogram& h, float total) {
  int largest = 0;
  for (int b = 0; b < kBins; ++b) {
    const auto i = static_cast<std::size_t>(b);
    const float before = b > 0 ? h[i - 1] : 0.0F;
    const float after = b + 1 < kBins ? h[i + 1] : 0.0F;
    const bool peak = h[i] > 0.0F && h[i] >= before && h[i] >= after;
    if (peak && before + h[i] + after >= kMinShare * total) return b;
    if (h[i] > h[static_cast<std::size_t>(largest)]) largest = b;
  }
  return largest;
}

}  // namespace

Layer nearest_layer(const Samples& samples, const StereoNoiseModel& noise) {
  const auto nearer = [](const Sample& a, const Sample& b) { return a.depth_m < b.depth_m; };
  const Axis axis(noise, std::min_element(samples.begin(), samples.end(), nearer)->depth_m);
  Histogram histogram{};
  for (const auto& s : samples) histogram[static_cast<std::size_t>(axis.bin(s.depth_m))] += 1.0F;

  const int mode = find_mode(histogram, static_cast<float>(samples.size));
  const float edge = kEdgeShare * histogram[static_cast<std::size_t>(mode)];
  int first = mode;
  int last = mode;
  while (first > 0 && histogram[static_cast<std::size_t>(first - 1)] > edge) --first;
  while (last + 1 < kBins && histogram[static_cast<std::size_t>(last + 1)] > edge) ++last;

  Layer layer{0.0F, 0.0F};
  bool found = false;
  for (const auto& s : samples) {
    const int bin = axis.bin(s.depth_m);
    if (bin < first || bin > last) continue;
    layer.near_m = found ? std::min(layer.near_m, s.depth_m) : s.depth_m;
    layer.far_m = found ? std::max(layer.far_m, s.depth_m) : s.depth_m;
    found = true;
  }
  return layer;
}

}  // namespace extperfc::depth
