#include "simulate/render/depth_noise.hpp"

#include <algorithm>
#include <cmath>

#include "simulate/render/lanes.hpp"

namespace extperfc::simulate {

namespace {

constexpr float kEdgePx = 1.0F;          // jump of disparity between neighbours that is an edge
constexpr float kShadowMarginPx = 2.0F;  // slanted surfaces do not hide themselves
constexpr float kShadowToEdge = 2.5F;    // matching rarely guesses what one eye does not see

struct Limits {
  float near, far;       // [m]
  float focal_baseline;  // [px m]
  float subpixel, step;  // [px]; step 0: none
  float units_per_m;     // of the result before rounding
  float mm_per_unit;
  float hole, edge, shadow;  // probabilities
};

/// Disparities of three rows; one more value stands at either end of a row.
struct RowPointers {
  const float *above, *disparity, *below;
  const float *noise, *in_shadow;
  std::uint16_t* out;
};

Limits limits_of(const DepthNoiseParams& p) {
  const double quantum = std::max(p.quantum_m, 1e-6);
  return {static_cast<float>(p.min_depth_m),
          static_cast<float>(std::min(p.max_depth_m, 65.534)),
          static_cast<float>(p.focal_px * p.baseline_m),
          static_cast<float>(p.subpixel_px),
          static_cast<float>(p.subpixel_px > 0 ? p.disparity_step_px : 0.0),
          static_cast<float>(1.0 / quantum),
          static_cast<float>(1000.0 * quantum),
          static_cast<float>(p.hole_probability),
          static_cast<float>(p.edge_holes),
          std::min(1.0F, kShadowToEdge * static_cast<float>(p.edge_holes))};
}

/// Rounds values above -0.5; unlike lround() it runs in all lanes.
inline float nearest(float value) {
  const float shifted = value + 0.5F;
  return static_cast<float>(static_cast<std::int32_t>(shifted));
}

inline float disparity(float depth, float focal_baseline) {
  return depth > 0.0F ? focal_baseline / depth : 0.0F;
}

EXTPERFC_LANES void to_disparity(const float* depth, int width, float focal_baseline, float* out) {
#pragma omp simd
  for (int x = 0; x < width; ++x) out[x] = disparity(depth[x], focal_baseline);
  out[-1] = out[0];
  out[width] = out[width - 1];
}

EXTPERFC_LANES void measure(const Limits& limits, const RowPointers& row, NoiseKey key, std::uint32_t first,
                            int width) {
  const float fb = limits.focal_baseline;
  const float inverse_step = limits.step > 0.0F ? 1.0F / limits.step : 0.0F;
#pragma omp simd
  for (int x = 0; x < width; ++x) {
    const float d = row.disparity[x];
    const float left = std::abs(row.disparity[x - 1] - d);
    const float right = std::abs(row.disparity[x + 1] - d);
    const float up = std::abs(row.above[x] - d);
    const float down = std::abs(row.below[x] - d);
    const float sides = left > right ? left : right;
    const float rows = up > down ? up : down;
    float lost = (sides > kEdgePx) | (rows > kEdgePx) ? limits.edge : limits.hole;
    lost = row.in_shadow[x] > 0.0F ? limits.shadow : lost;
    const float chance = uniform(noise_bits(key, first + static_cast<std::uint32_t>(x)));

    float measured = d + limits.subpixel * row.noise[x];
    const float stepped = nearest(measured * inverse_step) * limits.step;
    measured = limits.step > 0.0F ? stepped : measured;
    const float found = fb / (measured > 1e-3F ? measured : 1e-3F);
    const bool valid = (d > 0.0F) & (chance >= lost) & (found >= limits.near) & (found <= limits.far);
    const float units = nearest(found * limits.units_per_m);
    const float mm = valid ? units * limits.mm_per_unit + 0.5F : 0.0F;
    row.out[x] = static_cast<std::uint16_t>(static_cast<std::int32_t>(mm));
  }
}

}  // namespace

void DepthNoise::draw_noise(NoiseKey key, int patch, int y, int width) {
  const int shifted_y = y + static_cast<int>(key.a % static_cast<std::uint32_t>(patch));
  const int shift_x = static_cast<int>(key.b % static_cast<std::uint32_t>(patch));
  const int lattice_y = shifted_y / patch;
  const float b = static_cast<float>(shifted_y % patch) / static_cast<float>(patch);
  // A blend of independent values with weights w has the variance sum(w^2).
  const float scale_y = 1.0F / std::sqrt((1 - b) * (1 - b) + b * b);
  const int corners = (width + shift_x) / patch + 2;
  lattice_.resize(static_cast<std::size_t>(corners));
  for (int i = 0; i < corners; ++i) {
    const auto at = static_cast<std::uint32_t>(lattice_y * 8192 + i);
    const float upper = gauss(noise_bits(key, at));
    const float lower = gauss(noise_bits(key, at + 8192U));
    lattice_[static_cast<std::size_t>(i)] = scale_y * (upper + b * (lower - upper));
  }
  for (int i = 0; i + 1 < corners; ++i) {
    const float left = lattice_[static_cast<std::size_t>(i)];
    const float right = lattice_[static_cast<std::size_t>(i) + 1];
    for (int j = 0; j < patch; ++j) {
      const int x = i * patch + j - shift_x;
      if (x < 0 || x >= width) continue;
      const float a = static_cast<float>(j) / static_cast<float>(patch);
      noise_[static_cast<std::size_t>(x)] =
          (left + a * (right - left)) / std::sqrt((1 - a) * (1 - a) + a * a);
    }
  }
}

void DepthNoise::find_shadow(const float* disparities, int width, float shift_per_disparity) {
  std::fill(nearest_.begin(), nearest_.end(), 0.0F);
  const auto landing = [&](int x, float shift) {
    return static_cast<int>(nearest(static_cast<float>(x) - shift));
  };
  for (int x = 0; x < width; ++x) {
    const float shift = shift_per_disparity * disparities[x];
    const int at = landing(x, shift);
    if (at >= 0 && shift > nearest_[static_cast<std::size_t>(at)])
      nearest_[static_cast<std::size_t>(at)] = shift;
  }
  for (int x = 0; x < width; ++x) {
    const float shift = shift_per_disparity * disparities[x];
    const int at = landing(x, shift);
    const bool hidden = at >= 0 && nearest_[static_cast<std::size_t>(at)] > shift + kShadowMarginPx;
    in_shadow_[static_cast<std::size_t>(x)] = hidden ? 1.0F : 0.0F;
  }
}

void DepthNoise::apply(const CameraParams& params, NoiseKey key, CameraImages& images) {
  const auto width = static_cast<std::size_t>(images.width);
  const Limits limits = limits_of(params.depth);
  const int last = images.height - 1;
  noise_.resize(width);
  nearest_.resize(width + 1);
  in_shadow_.assign(width, 0.0F);
  for (auto& row : disparities_) row.resize(width + 2);
  // Row y lies in disparities_[(y + 3) % 3].
  const auto row = [&](int y) { return disparities_[static_cast<std::size_t>((y + 3) % 3)].data() + 1; };
  const auto read = [&](int y) {
    const auto from = width * static_cast<std::size_t>(std::clamp(y, 0, last));
    to_disparity(images.true_depth_m.data() + from, images.width, limits.focal_baseline, row(y));
  };
  const NoiseKey holes{~key.a, key.b + 1U};
  const int patch = std::max(1, static_cast<int>(std::lround(params.depth.correlation_px)));
  const auto widening = static_cast<float>(params.model.fx / params.depth.focal_px);
  read(-1);
  read(0);
  for (int y = 0; y <= last; ++y) {
    read(y + 1);
    if (limits.subpixel > 0.0F) draw_noise(key, patch, y, images.width);
    if (limits.shadow > 0.0F) find_shadow(row(y), images.width, widening);
    measure(limits,
            {row(y - 1), row(y), row(y + 1), noise_.data(), in_shadow_.data(),
             images.depth_mm.data() + width * static_cast<std::size_t>(y)},
            holes, static_cast<std::uint32_t>(y * images.width), images.width);
  }
}

}  // namespace extperfc::simulate
