#include "simulate/render/image_planes.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "simulate/render/lanes.hpp"

namespace extperfc::simulate {

namespace {

constexpr float kSameDepth = 0.03F;  // fraction of the depth by which a neighbour may be off

constexpr float kExposure = 1.22F;
constexpr float kKnee = 0.70F;  // where the shoulder begins

/// Shoulder of a film: straight up to kKnee, then ever flatter towards 1; then the display's curve.
inline float display(float light) {
  const float linear = kExposure * light;
  const float over = linear > kKnee ? linear - kKnee : 0.0F;
  const float straight = linear < kKnee ? linear : kKnee;
  return std::sqrt(straight + over / (1.0F + over * (1.0F / (1.0F - kKnee))));
}

EXTPERFC_LANES void spread_along(const float* depth, const float* seen, float* out, int width) {
#pragma omp simd
  for (int x = 0; x < width; ++x) {
    const float here = depth[x];
    const float band = kSameDepth * here;
    float sum = 0;
    float count = 0;
    for (int d = -2; d < 2; ++d) {
      const float value = seen[x + d];
      const bool counts = (value >= 0.0F) & (std::abs(depth[x + d] - here) < band);
      sum += counts ? value : 0.0F;
      count += counts ? 1.0F : 0.0F;
    }
    out[x] = count > 0.0F ? sum / count : -1.0F;
  }
}

EXTPERFC_LANES void spread_across(const float* const* depth, const float* const* seen, float* out,
                                  int width) {
  const float* here_row = depth[2];
#pragma omp simd
  for (int x = 0; x < width; ++x) {
    const float here = here_row[x];
    const float band = kSameDepth * here;
    float sum = 0;
    float count = 0;
    for (int d = 0; d < 4; ++d) {
      const float value = seen[d][x];
      const bool counts = (value >= 0.0F) & (std::abs(depth[d][x] - here) < band);
      sum += counts ? value : 0.0F;
      count += counts ? 1.0F : 0.0F;
    }
    out[x] = count > 0.0F ? sum / count : 1.0F;
  }
}

EXTPERFC_LANES void resolve_channel(const float* direct, const float* ambient, const float* light_seen,
                                    const float* sky_seen, int width, float* out) {
#pragma omp simd
  for (int x = 0; x < width; ++x)
    out[x] = display(direct[x] * light_seen[x] + ambient[x] * (0.22F + 0.78F * sky_seen[x]));
}

}  // namespace

float light_of(float shown) {
  const float linear = std::min(shown * shown, 0.98F);
  const float over = std::max(0.0F, linear - kKnee);
  return (std::min(linear, kKnee) + over / (1.0F - over * (1.0F / (1.0F - kKnee)))) / kExposure;
}

void Plane::resize(int width, int height) {
  if (width == width_ && height == height_) return;
  width_ = width;
  height_ = height;
  const int columns = (width + 15) / 16 * 16 + 2 * kBorder;
  const int rows = (height + 3) / 4 * 4 + 2 * kBorderRows;
  stride_ = static_cast<std::size_t>(columns);
  data_.assign(stride_ * static_cast<std::size_t>(rows), -1.0F);
}

void ImagePlanes::resize(int width, int height) {
  for (auto* plane : {&depth, &direct[0], &direct[1], &direct[2], &ambient[0], &ambient[1], &ambient[2],
                      &light_seen, &sky_seen})
    plane->resize(width, height);
}

void store(const float* lanes, int x, int y, Plane& plane) {
  for (int row = 0; row < 4; ++row) std::memcpy(plane.row(y + row) + x, lanes + 4 * row, 4 * sizeof(float));
}

void spread(const Plane& depth, Plane& seen, Plane& scratch, int width, int height) {
  for (int y = 0; y < height; ++y) spread_along(depth.row(y), seen.row(y), scratch.row(y), width);
  for (int y = 0; y < height; ++y) {
    const float* depths[4];
    const float* values[4];
    for (int d = 0; d < 4; ++d) {
      depths[d] = depth.row(y + d - 2);
      values[d] = scratch.row(y + d - 2);
    }
    spread_across(depths, values, seen.row(y), width);
  }
}

void resolve_row(const ImagePlanes& planes, int y, int width, float* red, float* green, float* blue) {
  float* out[3] = {red, green, blue};
  for (int i = 0; i < 3; ++i)
    resolve_channel(planes.direct[i].row(y), planes.ambient[i].row(y), planes.light_seen.row(y),
                    planes.sky_seen.row(y), width, out[i]);
}

}  // namespace extperfc::simulate
