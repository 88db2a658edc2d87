#include "simulate/render/lattice_noise.hpp"

#include <algorithm>
#include <cmath>

#include "simulate/render/hash_noise.hpp"

namespace extperfc::simulate {

namespace {

int wrapped_cell(int i, int period) {
  return ((i % period) + period) % period;
}

}  // namespace

float smooth_step(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0F, 1.0F);
  return t * t * (3.0F - 2.0F * t);
}

float cell(std::uint32_t layer, int x, int y) {
  return uniform(noise_bits({layer * 0x68E31DA4U + 17U, layer}, static_cast<std::uint32_t>(y * 4096 + x)));
}

float lattice(std::uint32_t layer, float x, float y, int across, int down) {
  const float fx = x * static_cast<float>(across);
  const float fy = y * static_cast<float>(down);
  const int ix = static_cast<int>(std::floor(fx));
  const int iy = static_cast<int>(std::floor(fy));
  const float tx = smooth_step(0, 1, fx - static_cast<float>(ix));
  const float ty = smooth_step(0, 1, fy - static_cast<float>(iy));
  const auto at = [&](int dx, int dy) {
    return cell(layer, wrapped_cell(ix + dx, across), wrapped_cell(iy + dy, down));
  };
  const float top = at(0, 0) + (at(1, 0) - at(0, 0)) * tx;
  const float bottom = at(0, 1) + (at(1, 1) - at(0, 1)) * tx;
  return top + (bottom - top) * ty;
}

float octaves(std::uint32_t layer, float x, float y, int across, int down, int count) {
  float sum = 0;
  float weight = 0.5F;
  float total = 0;
  for (int i = 0; i < count; ++i, across *= 2, down *= 2, weight *= 0.5F) {
    sum += weight * lattice(layer + static_cast<std::uint32_t>(i), x, y, across, down);
    total += weight;
  }
  return sum / total;
}

}  // namespace extperfc::simulate
