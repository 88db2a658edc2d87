#include "simulate/render_tool/camera_effects.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "extperfc/base/math.hpp"

namespace extperfc::simulate {

namespace {
constexpr double kMiddleGrey = 0.44;  // mean brightness that automatic exposure aims at

/// A line or bell of weights over neighbours (dx, dy).
struct Tap {
  int dx;
  int dy;
  float weight;
};

std::vector<Tap> normalised(std::vector<Tap> taps) {
  float sum = 0;
  for (const Tap& tap : taps) sum += tap.weight;
  for (Tap& tap : taps) tap.weight /= sum;
  return taps;
}

std::vector<Tap> bell(double sigma) {
  const int reach = static_cast<int>(std::ceil(2.5 * sigma));
  std::vector<Tap> taps;
  for (int dy = -reach; dy <= reach; ++dy)
    for (int dx = -reach; dx <= reach; ++dx)
      taps.push_back({dx, dy, static_cast<float>(std::exp(-(dx * dx + dy * dy) / (2 * sigma * sigma)))});
  return normalised(std::move(taps));
}

std::vector<Tap> stroke(double length, double angle) {
  std::vector<Tap> taps;
  const int count = std::max(2, static_cast<int>(std::lround(length)));
  for (int i = 0; i < count; ++i) {
    const double along = (i - (count - 1) / 2.0);
    taps.push_back({static_cast<int>(std::lround(along * std::cos(angle))),
                    static_cast<int>(std::lround(along * std::sin(angle))), 1.0F});
  }
  return normalised(std::move(taps));
}

void convolve(std::vector<std::uint8_t>& rgb, int width, int height, const std::vector<Tap>& taps) {
  const std::vector<std::uint8_t> source = rgb;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      std::array<float, 3> sum{};
      for (const Tap& tap : taps) {
        const int column = std::clamp(x + tap.dx, 0, width - 1);
        const int row = std::clamp(y + tap.dy, 0, height - 1);
        const std::size_t at = 3 * (static_cast<std::size_t>(row) * width + column);
        for (std::size_t c = 0; c < 3; ++c) sum[c] += tap.weight * source[at + c];
      }
      const std::size_t at = 3 * (static_cast<std::size_t>(y) * width + x);
      for (std::size_t c = 0; c < 3; ++c) rgb[at + c] = static_cast<std::uint8_t>(std::lrint(sum[c]));
    }
}

double mean_brightness(const std::vector<std::uint8_t>& rgb) {
  double sum = 0;
  for (std::size_t i = 1; i < rgb.size(); i += 3 * 7) sum += rgb[i];
  return sum / (255.0 * std::max<double>(1, static_cast<double>(rgb.size()) / 21));
}

/// Spread of what goes wrong.
struct Spread {
  double exposure;       ///< standard deviation of the logarithm of brightness
  double white_balance;  ///< likewise of each channel
  double gamma;
  float min_saturation, max_saturation;
  float vignette;
  double blurred;  ///< fraction of images out of focus
  double focus_px;
  double moved;  ///< fraction of images with motion blur
  double motion_px;
  double noise;  ///< standard deviation of its standard deviation
};
constexpr Spread kUsualSpread{0.22, 0.05, 0.1, 0.65F, 1.15F, 0.25F, 0.3, 0.8, 0.12, 6, 0.012};
constexpr Spread kPoorSpread{0.42, 0.13, 0.2, 0.25F, 1.4F, 0.6F, 0.35, 1.6, 0.2, 12, 0.028};

/// One table per channel: exposure, white balance, gamma.
std::array<std::array<float, 256>, 3> tone_tables(Rng& rng, double brightness, const Spread& spread) {
  const double aim = kMiddleGrey * std::exp(rng.normal(0, spread.exposure));
  const double exposure = std::clamp(std::pow(aim / std::max(0.05, brightness), 0.75), 0.5, 2.2);
  const double gamma = std::exp(rng.normal(0, spread.gamma));
  const double lift = rng.chance(0.2) ? rng.uniform(0, 0.08) : 0;
  std::array<std::array<float, 256>, 3> tables{};
  for (auto& table : tables) {
    const double gain = exposure * std::exp(rng.normal(0, spread.white_balance));
    for (std::size_t i = 0; i < table.size(); ++i) {
      const double value = std::min(1.0, std::pow(static_cast<double>(i) / 255, gamma) * gain);
      table[i] = static_cast<float>(255 * (lift + (1 - lift) * value));
    }
  }
  return tables;
}

void tone(Rng& rng, std::vector<std::uint8_t>& rgb, int width, int height, const Spread& spread) {
  const auto tables = tone_tables(rng, mean_brightness(rgb), spread);
  const auto saturation = static_cast<float>(rng.uniform(spread.min_saturation, spread.max_saturation));
  const auto vignette = static_cast<float>(rng.uniform(0, spread.vignette));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t at = 3 * (static_cast<std::size_t>(y) * width + x);
      const float right = 2.0F * static_cast<float>(x) / static_cast<float>(width) - 1;
      const float down = 2.0F * static_cast<float>(y) / static_cast<float>(height) - 1;
      const float fall = 1 - vignette * (right * right + down * down) / 2;
      const std::array<float, 3> value{tables[0][rgb[at]], tables[1][rgb[at + 1]], tables[2][rgb[at + 2]]};
      const float grey = (value[0] + value[1] + value[2]) / 3;
      for (std::size_t c = 0; c < 3; ++c)
        rgb[at + c] = static_cast<std::uint8_t>(
            std::clamp(fall * (grey + saturation * (value[c] - grey)) + 0.5F, 0.0F, 255.0F));
    }
}

/// Noise of triangular distribution, which is near enough to a bell.
void add_noise(Rng& rng, std::vector<std::uint8_t>& rgb, double sigma) {
  std::uint64_t state = static_cast<std::uint64_t>(rng.integer(1, 2000000000)) * 0x9E3779B97F4A7C15U;
  const auto scale = static_cast<float>(sigma * 255 * std::sqrt(6.0) / 65536);
  const auto add = [scale](std::uint8_t value, std::uint64_t bits) {
    const float sum =
        static_cast<float>(bits & 0xFFFFU) + static_cast<float>((bits >> 16U) & 0xFFFFU) - 65535.0F;
    return static_cast<std::uint8_t>(
        std::clamp(static_cast<float>(value) + scale * sum + 0.5F, 0.0F, 255.0F));
  };
  for (std::size_t i = 0; i + 1 < rgb.size(); i += 2) {
    state ^= state << 13U;  // xorshift64 (Marsaglia 2003)
    state ^= state >> 7U;
    state ^= state << 17U;
    rgb[i] = add(rgb[i], state);
    rgb[i + 1] = add(rgb[i + 1], state >> 32U);
  }
}

}  // namespace

void apply_camera_effects(Rng& rng, std::vector<std::uint8_t>& rgb, int width, int height,
                          CameraQuality quality) {
  const Spread& spread = quality == CameraQuality::kPoor ? kPoorSpread : kUsualSpread;
  const double unit = height / 480.0;
  const double kind = rng.uniform(0, 1);
  const double amount = rng.uniform(0, 1);
  const double angle = rng.uniform(0, kPi);
  if (kind < spread.blurred)
    convolve(rgb, width, height, bell(unit * (0.4 + spread.focus_px * amount)));
  else if (kind < spread.blurred + spread.moved)
    convolve(rgb, width, height, stroke(unit * (3 + spread.motion_px * amount), angle));
  tone(rng, rgb, width, height, spread);
  add_noise(rng, rgb, std::abs(rng.normal(0, spread.noise)));
}

}  // namespace extperfc::simulate
