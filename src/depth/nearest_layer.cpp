#include "depth/nearest_layer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace extperfc::depth {

namespace {

constexpr int kBins = 512;
constexpr double kRelativeWidth = 0.02;  // of a bin where noise does not matter: slant and shape of an object
constexpr double kNoiseWidth = 2.0;      // of a bin where noise rules, in standard deviations
constexpr float kMinModeFraction = 0.15F;  // of all samples in a mode; less is a flying pixel or an edge
constexpr float kEdgeFraction = 0.35F;     // of the mode's height, down to which its slopes belong to it

/// Depth axis on which a bin is `width(z) = kRelativeWidth * z + kNoiseWidth * sigma(z)` wide everywhere.
/// With sigma(z) = c z^2 the position is the closed integral of dz / width(z).
class Axis {
 public:
  Axis(const StereoNoiseModel& noise, float nearest_m)
      : c_(static_cast<float>(kNoiseWidth * noise.sigma_inverse_depth())), origin_(position(nearest_m)) {}

  /// Depth at which a bin begins.
  [[nodiscard]] float depth(int bin) const {
    const float e = std::exp(kR * (static_cast<float>(bin) + origin_));
    const float rest = 1.0F - c_ * e;
    return rest > 0.0F ? kR * e / rest : std::numeric_limits<float>::max();
  }
  [[nodiscard]] int bin(float z) const {
    return std::clamp(static_cast<int>(position(z) - origin_), 0, kBins - 1);
  }

 private:
  static constexpr auto kR = static_cast<float>(kRelativeWidth);
  [[nodiscard]] float position(float z) const { return std::log(z / (kR + c_ * z)) / kR; }
  float c_;
  float origin_;
};

using Histogram = std::array<float, kBins>;

/// Nearest bin that is a local maximum and, with its two neighbours, holds the minimum fraction; else the
/// largest.
int find_mode(const Histogram& h, float total) {
  int largest = 0;
  for (int b = 0; b < kBins; ++b) {
    const auto i = static_cast<std::size_t>(b);
    const float before = b > 0 ? h[i - 1] : 0.0F;
    const float after = b + 1 < kBins ? h[i + 1] : 0.0F;
    const bool peak = h[i] > 0.0F && h[i] >= before && h[i] >= after;
    if (peak && before + h[i] + after >= kMinModeFraction * total) return b;
    if (h[i] > h[static_cast<std::size_t>(largest)]) largest = b;
  }
  return largest;
}

}  // namespace

Layer nearest_layer(const Samples& samples, const StereoNoiseModel& noise) {
  constexpr float kRounding = 1e-4F;  // a sample on the edge of its bin belongs to the layer all the same
  const auto nearer = [](const Sample& a, const Sample& b) { return a.depth_m < b.depth_m; };
  const auto [nearest, farthest] = std::minmax_element(samples.begin(), samples.end(), nearer);
  const Axis axis(noise, nearest->depth_m);
  Histogram histogram{};
  for (const auto& s : samples) histogram[static_cast<std::size_t>(axis.bin(s.depth_m))] += 1.0F;

  const int mode = find_mode(histogram, static_cast<float>(samples.size));
  const auto belongs = [&](int bin) {
    return bin >= 0 && bin < kBins &&
           histogram[static_cast<std::size_t>(bin)] >
               kEdgeFraction * histogram[static_cast<std::size_t>(mode)];
  };
  int first = mode;
  int last = mode;
  while (belongs(first - 1)) --first;
  while (belongs(last + 1)) ++last;
  return {axis.depth(first) * (1.0F - kRounding),
          std::min(axis.depth(last + 1), farthest->depth_m) * (1.0F + kRounding)};
}

}  // namespace extperfc::depth
