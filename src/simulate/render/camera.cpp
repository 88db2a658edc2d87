#include "simulate/render/camera.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "simulate/render/lanes.hpp"

namespace extperfc::simulate {

namespace {

constexpr std::size_t kTables = 6;
constexpr LaneMask kAllLanes{{-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1}};

/// What the streams of noise of one sensor are for.
enum NoiseStream : std::uint32_t { kColourNoise = 1, kDepthNoiseStream = 2 };

bool same(const CameraModel& a, const CameraModel& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx &&
         a.cy == b.cy && a.distortion == b.distortion;
}

void resize(CameraImages& images, int width, int height) {
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  images.width = width;
  images.height = height;
  images.rgb.resize(3 * pixels);
  images.depth_mm.resize(pixels);
  images.true_depth_m.resize(pixels);
  images.instance.resize(pixels);
}

/// Means of pairs of pixels of two rows.
void halve_rows(const float* upper, const float* lower, int width, float* out) {
  for (int x = 0; x < width; ++x)
    out[x] = 0.25F * (upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1]);
}

/// Display values in [0, 1] to bytes, with noise of `sigma` bytes.
EXTPERFC_LANES void quantise(const float* values, int width, float sigma, NoiseKey key, std::uint32_t first,
                             std::uint8_t* bytes) {
#pragma omp simd
  for (int x = 0; x < width; ++x) {
    const float noise = sigma * gauss(noise_bits(key, first + static_cast<std::uint32_t>(x)));
    const float value = values[x] * 255.0F + 0.5F + noise;
    const float limited = value < 0.0F ? 0.0F : (value > 255.0F ? 255.0F : value);
    bytes[x] = static_cast<std::uint8_t>(static_cast<std::int32_t>(limited));
  }
}

void interleave(const std::uint8_t* const* planes, int width, std::uint8_t* rgb) {
  for (int x = 0; x < width; ++x) {
    rgb[3 * x] = planes[0][x];
    rgb[3 * x + 1] = planes[1][x];
    rgb[3 * x + 2] = planes[2][x];
  }
}

}  // namespace

RayTable::RayTable(const CameraModel& model, int supersampling)
    : model_(model),
      supersampling_(supersampling),
      columns_((model.width * supersampling + 3) / 4),
      rows_((model.height * supersampling + 3) / 4),
      slopes_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) * 2 * kLanes) {
  float* out = slopes_.data();
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column, out += 2 * kLanes) {
      for (int k = 0; k < kLanes; ++k) {
        const int x = 4 * column + k % 4;
        const int y = 4 * row + k / 4;
        const double u = (x + 0.5) / supersampling - 0.5;
        const double v = (y + 0.5) / supersampling - 0.5;
        const Eigen::Vector3d slope = model.back_project(u, v, 1.0);
        out[k] = static_cast<float>(slope.x());
        out[kLanes + k] = static_cast<float>(slope.y());
      }
    }
  }
}

bool RayTable::is_for(const CameraModel& model, int supersampling) const {
  return supersampling == supersampling_ && same(model, model_);
}

const RayTable& Camera::table(const CameraModel& model, int supersampling) {
  const auto found = std::find_if(tables_.begin(), tables_.end(),
                                  [&](const RayTable& t) { return t.is_for(model, supersampling); });
  if (found != tables_.end()) return *found;
  if (tables_.size() >= kTables) tables_.erase(tables_.begin());
  tables_.emplace_back(model, supersampling);
  return tables_.back();
}

void Camera::render(const CameraParams& params, const Pose& world_T_optical, const Scene& scene,
                    const LightSpec& light, std::uint64_t seed, double time_s, CameraImages& images) {
  const auto& model = params.model;
  const bool usable = model.validate().has_value();
  resize(images, usable ? model.width : 0, usable ? model.height : 0);
  if (!usable) return;
  const int samples = params.supersampling >= 2 ? 2 : 1;
  View view = make_view(world_T_optical, light, model.fx * samples, params.soft_light);
  planes_.resize(model.width * samples, model.height * samples);
  scratch_.resize(model.width * samples, model.height * samples);
  clear(packet_.ray);
  clear(packet_.hit);
  clear(shadow_);
  clear(around_.ray);
  clear(around_.hit);
  shade(scene, view, table(model, samples), params, images);
  if (samples > 1) trace_centres(scene, view, table(model, 1), images);
  finish(params, noise_key(seed, params.sensor, time_s, kColourNoise), images);
  depth_noise_.apply(params, noise_key(seed, params.sensor, time_s, kDepthNoiseStream), images);
}

void Camera::shade(const Scene& scene, const View& view, const RayTable& table, const CameraParams& params,
                   CameraImages& images) {
  const bool plain = params.supersampling < 2;
  for (int row = 0; row < table.rows(); ++row) {
    for (int column = 0; column < table.columns(); ++column) {
      aim(view, table.tile(column, row), packet_);
      scene.rays().intersect(kAllLanes, true, packet_);
      gather(scene, packet_, tile_);
      shade_tile(scene, view, params, 4 * column, 4 * row);
      if (plain) store_geometry(4 * column, 4 * row, images);
    }
  }
}

namespace {

/// 1: free, 0: occluded, -1: not asked.
void seen_lanes(const LaneMask& asked, const Rays& rays, float* seen) {
  for (int k = 0; k < kLanes; ++k) seen[k] = asked.on[k] == 0 ? -1.0F : (rays.far[k] < 0.0F ? 0.0F : 1.0F);
}

/// How far the view is free, as a fraction of the reach; -1: not asked. Fades out smoothly where the reach
/// ends.
void free_lanes(const LaneMask& asked, const RayPacket& packet, float* seen) {
  for (int k = 0; k < kLanes; ++k) seen[k] = asked.on[k] == 0 ? -1.0F : packet.ray.far[k] * (1.0F / kReach_m);
}

bool any(const LaneMask& mask) {
  return std::any_of(std::begin(mask.on), std::end(mask.on), [](std::int32_t on) { return on != 0; });
}

}  // namespace

void Camera::shade_tile(const Scene& scene, const View& view, const CameraParams& params, int x, int y) {
  alignas(64) float seen[kLanes];
  light(view, packet_, tile_, shadow_, mask_);
  if (params.shadows && any(mask_)) scene.rays().occluded(mask_, shadow_);
  seen_lanes(mask_, shadow_, seen);
  store(seen, x, y, planes_.light_seen);
  if (params.soft_light) {
    look_around(tile_, around_, mask_);
    if (any(mask_)) scene.rays().intersect(mask_, false, around_);
    free_lanes(mask_, around_, seen);
  } else {
    std::fill(std::begin(seen), std::end(seen), 1.0F);
  }
  store(seen, x, y, planes_.sky_seen);
  fetch_textures(tile_);
  reflect(tile_);
  for (int k = 0; k < kLanes; ++k) seen[k] = tile_.hit[k] != 0 ? packet_.ray.far[k] : -1.0F;
  store(seen, x, y, planes_.depth);
  for (int k = 0; k < kLanes; ++k) {
    if (tile_.hit[k] != 0) continue;
    for (int i = 0; i < 3; ++i) {
      tile_.from_light[i][k] = 0.0F;
      tile_.from_around[i][k] = view.background[i];
    }
  }
  for (int i = 0; i < 3; ++i) {
    store(tile_.from_light[i], x, y, planes_.direct[i]);
    store(tile_.from_around[i], x, y, planes_.ambient[i]);
  }
}

void Camera::trace_centres(const Scene& scene, const View& view, const RayTable& table,
                           CameraImages& images) {
  for (int row = 0; row < table.rows(); ++row) {
    for (int column = 0; column < table.columns(); ++column) {
      aim(view, table.tile(column, row), packet_);
      scene.rays().intersect(kAllLanes, true, packet_);
      gather(scene, packet_, tile_);
      store_geometry(4 * column, 4 * row, images);
    }
  }
}

void Camera::store_geometry(int x, int y, CameraImages& images) const {
  const int columns = std::min(4, images.width - x);
  const int rows = std::min(4, images.height - y);
  for (int j = 0; j < rows; ++j) {
    const auto at = static_cast<std::size_t>(y + j) * static_cast<std::size_t>(images.width) + x;
    for (int i = 0; i < columns; ++i) {
      const int k = 4 * j + i;
      images.true_depth_m[at + i] = tile_.hit[k] != 0 ? packet_.ray.far[k] : 0.0F;
      images.instance[at + i] = tile_.instance[k];
    }
  }
}

void Camera::finish(const CameraParams& params, NoiseKey key, CameraImages& images) {
  const int samples = params.supersampling >= 2 ? 2 : 1;
  const int width = images.width;
  const int full_width = samples * width;
  const int full_height = samples * images.height;
  if (params.soft_light) {
    spread(planes_.depth, planes_.light_seen, scratch_, full_width, full_height);
    spread(planes_.depth, planes_.sky_seen, scratch_, full_width, full_height);
  }
  const auto stride = (static_cast<std::size_t>(full_width) + 15) / 16 * 16;
  rows_.resize(6 * stride);
  std::vector<std::uint8_t> bytes(3 * stride);
  const std::uint8_t* const channels[3] = {bytes.data(), bytes.data() + stride, bytes.data() + 2 * stride};
  const auto sigma = static_cast<float>(255.0 * params.image_noise);
  for (int y = 0; y < images.height; ++y) {
    float* const upper = rows_.data();
    float* const lower = upper + 3 * stride;
    resolve_row(planes_, samples * y, full_width, upper, upper + stride, upper + 2 * stride);
    if (samples > 1) {
      resolve_row(planes_, 2 * y + 1, full_width, lower, lower + stride, lower + 2 * stride);
      for (std::size_t i = 0; i < 3; ++i)
        halve_rows(upper + i * stride, lower + i * stride, width, upper + i * stride);
    }
    for (std::size_t i = 0; i < 3; ++i)
      quantise(upper + i * stride, width, sigma, key,
               static_cast<std::uint32_t>((3 * y + static_cast<int>(i)) * width), bytes.data() + i * stride);
    interleave(channels, width,
               images.rgb.data() + 3 * static_cast<std::size_t>(y) * static_cast<std::size_t>(width));
  }
}

}  // namespace extperfc::simulate
