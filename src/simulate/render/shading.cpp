#include "simulate/render/shading.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "simulate/render/image_planes.hpp"
#include "simulate/render/lanes.hpp"

namespace extperfc::simulate {

namespace {

/// Values that differ between the lanes of a tile and repeat from tile to tile: what one pixel lacks its
/// neighbours have, and a mean over any 4 x 4 pixels has them all.
struct alignas(64) LanePattern {
  float light_x[kLanes], light_y[kLanes];  ///< point of a unit disc
  float around[3][kLanes];                 ///< direction about the normal, dense where the cosine is large
  std::int32_t asks[kLanes];               ///< -1: the lane looks around, as every second does
  float level[kLanes];                     ///< factor in [1, 2) that rounds texture levels up or down
};

LanePattern make_pattern() {
  // Order in which a 4 x 4 tile is filled most evenly.
  constexpr int kOrder[kLanes] = {0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};
  constexpr float kGoldenAngle = 2.39996323F;
  LanePattern pattern{};
  for (int k = 0; k < kLanes; ++k) {
    const float rank = (static_cast<float>(kOrder[k]) + 0.5F) / kLanes;
    const float disc = std::sqrt(rank);
    const float angle = kGoldenAngle * static_cast<float>(kOrder[k]);
    pattern.light_x[k] = disc * std::cos(angle);
    pattern.light_y[k] = disc * std::sin(angle);
    pattern.asks[k] = k % 2 == 0 && k / 4 % 2 == 0 ? -1 : 0;
    const int other = kOrder[k] % 4;
    const float flat = std::sqrt((static_cast<float>(other) + 1.0F) / 6.0F);
    const float azimuth = 1.5707963F * static_cast<float>(other) + 0.5F;
    pattern.around[0][k] = flat * std::cos(azimuth);
    pattern.around[1][k] = flat * std::sin(azimuth);
    pattern.around[2][k] = std::sqrt(1.0F - flat * flat);
    pattern.level[k] = std::exp2(rank);
  }
  return pattern;
}

const LanePattern kPattern = make_pattern();

/// Where shadow rays start: off the surface by more than rounding and facets.
constexpr float kLift = 6e-4F;

}  // namespace

View make_view(const Pose& world_T_optical, const LightSpec& light, double fx, bool soft) {
  View view{};
  for (int i = 0; i < 3; ++i) {
    view.origin[i] = static_cast<float>(world_T_optical.translation()[i]);
    view.right[i] = static_cast<float>(world_T_optical.linear()(i, 0));
    view.down[i] = static_cast<float>(world_T_optical.linear()(i, 1));
    view.forward[i] = static_cast<float>(world_T_optical.linear()(i, 2));
    view.light[i] = static_cast<float>(light.position_m[i]);
    view.sky[i] = light.sky[i] * light.sky[i];
    view.background[i] = light_of(light.sky[i]);
  }
  view.near = 0.03F;
  view.far = 200.0F;
  view.pixel_width = static_cast<float>(1.0 / fx);
  view.light_radius = soft ? 0.14F : 0.0F;
  view.direct_weight = light.direct;
  view.ambient_weight = light.ambient;
  return view;
}

EXTPERFC_LANES void aim(const View& view, const float* slopes, RayPacket& packet) {
  Rays& ray = packet.ray;
  Hits& hit = packet.hit;
#pragma omp simd
  for (int k = 0; k < kLanes; ++k) {
    const float x = slopes[k];
    const float y = slopes[kLanes + k];
    ray.org_x[k] = view.origin[0];
    ray.org_y[k] = view.origin[1];
    ray.org_z[k] = view.origin[2];
    ray.dir_x[k] = view.forward[0] + x * view.right[0] + y * view.down[0];
    ray.dir_y[k] = view.forward[1] + x * view.right[1] + y * view.down[1];
    ray.dir_z[k] = view.forward[2] + x * view.right[2] + y * view.down[2];
    ray.near[k] = view.near;
    ray.far[k] = view.far;
    hit.mesh_instance[k] = kNoHit;
    hit.geometry[k] = kNoHit;
  }
}

void gather(const Scene& scene, const RayPacket& packet, Tile& tile) {
  const Hits& hit = packet.hit;
  for (int k = 0; k < kLanes; ++k) {
    tile.texture[k] = nullptr;
    if (hit.mesh_instance[k] == kNoHit) {
      tile.hit[k] = 0;
      tile.normal[0][k] = tile.normal[1][k] = 0.0F;
      tile.normal[2][k] = 1.0F;
      tile.albedo[0][k] = tile.albedo[1][k] = tile.albedo[2][k] = 0.0F;
      tile.gloss[k] = tile.pixels_per_m[k] = tile.texture_u[k] = tile.texture_v[k] = 0.0F;
      tile.instance[k] = 0;
      continue;
    }
    const TriangleRecord& record = scene.record(hit.mesh_instance[k], hit.triangle[k]);
    const TriangleSurface& surface = scene.surfaces()[record.surface];
    const float u = hit.u[k];
    const float v = hit.v[k];
    const float w = 1.0F - u - v;
    float n[3];
    for (int i = 0; i < 3; ++i)
      n[i] = w * record.normal[0][i] + u * record.normal[1][i] + v * record.normal[2][i];
    const MeshFrame& frame = scene.frame(hit.mesh_instance[k]);
    if (frame.rotated) {
      const float* r = frame.rotation;
      const float local[3] = {n[0], n[1], n[2]};
      for (int i = 0; i < 3; ++i) n[i] = r[i] * local[0] + r[3 + i] * local[1] + r[6 + i] * local[2];
    }
    tile.hit[k] = -1;
    for (int i = 0; i < 3; ++i) {
      tile.normal[i][k] = n[i];
      tile.albedo[i][k] = surface.albedo[static_cast<std::size_t>(i)];
    }
    tile.gloss[k] = surface.gloss;
    tile.pixels_per_m[k] = surface.pixels_per_m;
    tile.instance[k] = surface.instance;
    tile.texture[k] = surface.texture;
    tile.texture_u[k] = w * record.texture[0][0] + u * record.texture[1][0] + v * record.texture[2][0];
    tile.texture_v[k] = w * record.texture[0][1] + u * record.texture[1][1] + v * record.texture[2][1];
  }
}

EXTPERFC_LANES void light(const View& view, const RayPacket& packet, Tile& tile, Rays& to_light,
                          LaneMask& lit) {
  const Rays& ray = packet.ray;
#pragma omp simd
  for (int k = 0; k < kLanes; ++k) {
    const float dx = ray.dir_x[k];
    const float dy = ray.dir_y[k];
    const float dz = ray.dir_z[k];
    float nx = tile.normal[0][k];
    float ny = tile.normal[1][k];
    float nz = tile.normal[2][k];
    const float n_dot_d = nx * dx + ny * dy + nz * dz;
    const float unit_n = (n_dot_d > 0.0F ? -1.0F : 1.0F) / std::sqrt(nx * nx + ny * ny + nz * nz);
    nx *= unit_n;
    ny *= unit_n;
    nz *= unit_n;
    tile.normal[0][k] = nx;
    tile.normal[1][k] = ny;
    tile.normal[2][k] = nz;
    const float depth = tile.hit[k] != 0 ? ray.far[k] : 1.0F;
    const float px = ray.org_x[k] + depth * dx;
    const float py = ray.org_y[k] + depth * dy;
    const float pz = ray.org_z[k] + depth * dz;
    tile.point[0][k] = px;
    tile.point[1][k] = py;
    tile.point[2][k] = pz;

    // Towards the middle of the light: Lambert's law, and less light farther away.
    float lx = view.light[0] - px;
    float ly = view.light[1] - py;
    float lz = view.light[2] - pz;
    const float distance2 = lx * lx + ly * ly + lz * lz;
    const float unit_l = 1.0F / std::sqrt(distance2 + 1e-12F);
    const float cosine = (nx * lx + ny * ly + nz * lz) * unit_l;
    const float facing = cosine > 0.0F ? cosine : 0.0F;
    const float falloff = 1.30F / (1.0F + distance2 * (1.0F / 12.0F));
    const float incident = view.direct_weight * falloff;
    tile.direct[k] = incident * facing;

    // Blinn's highlight.
    const float unit_d = 1.0F / std::sqrt(dx * dx + dy * dy + dz * dz);
    const float hx = lx * unit_l - dx * unit_d;
    const float hy = ly * unit_l - dy * unit_d;
    const float hz = lz * unit_l - dz * unit_d;
    const float unit_h = 1.0F / std::sqrt(hx * hx + hy * hy + hz * hz + 1e-12F);
    const float half = (nx * hx + ny * hy + nz * hz) * unit_h;
    float power = half > 0.0F ? half : 0.0F;
    power *= power;
    power *= power;
    power *= power;
    power *= power;
    power *= power;
    tile.highlight[k] = facing > 0.0F ? tile.gloss[k] * incident * power : 0.0F;

    // Light from all around: the sky above, what floor and walls send back, a little from one side so that
    // walls differ.
    const float up = 0.5F + 0.5F * nz;
    const float side = 1.0F + 0.07F * nx + 0.10F * ny;
    // A glossy surface mirrors its surroundings where it is seen at a flat angle.
    const float view_cosine = -(nx * dx + ny * dy + nz * dz) * unit_d;
    const float flat = 1.0F - (view_cosine > 0.0F ? view_cosine : 0.0F);
    const float rim = 0.30F * tile.gloss[k] * flat * flat * flat * (0.3F + 0.7F * up);
    const float fraction = view.ambient_weight * side;
    tile.rim[k] = fraction * rim;
    tile.ambient[0][k] = fraction * (0.60F + up * (0.24F + 0.20F * view.sky[0]));
    tile.ambient[1][k] = fraction * (0.56F + up * (0.28F + 0.20F * view.sky[1]));
    tile.ambient[2][k] = fraction * (0.51F + up * (0.33F + 0.20F * view.sky[2]));

    // Size of a pixel on the surface, in pixels of the texture; halfway between its two sides when slanted.
    const float slant = view_cosine > 0.08F ? view_cosine : 0.08F;
    const float spread = depth * view.pixel_width * tile.pixels_per_m[k] / std::sqrt(slant);
    const float rounded = (spread > 1.0F ? spread : 1.0F) * 0.72F * kPattern.level[k];
    std::int32_t bits = 0;
    std::memcpy(&bits, &rounded, sizeof(bits));
    std::int32_t level = (bits >> 23) - 127;
    level = level < 0 ? 0 : (level > MipTexture::kLevels - 1 ? MipTexture::kLevels - 1 : level);
    const std::int32_t size = MipTexture::kSize >> level;
    const std::int32_t last = size - 1;
    // Places in 1/256 of a pixel; a pixel's value stands at its centre.
    const float scale = 256.0F * static_cast<float>(size);
    const std::int32_t u = static_cast<std::int32_t>(tile.texture_u[k] * scale) - 128;
    const std::int32_t v = static_cast<std::int32_t>(tile.texture_v[k] * scale) - 128;
    const std::int32_t left = (u >> 8) & last;
    const std::int32_t right = (left + 1) & last;
    const std::int32_t upper = MipTexture::first_pixel(size) + ((v >> 8) & last) * size;
    const std::int32_t lower = MipTexture::first_pixel(size) + (((v >> 8) + 1) & last) * size;
    tile.texel[0][k] = upper + left;
    tile.texel[1][k] = upper + right;
    tile.texel[2][k] = lower + left;
    tile.texel[3][k] = lower + right;
    tile.texel_x[k] = u & 0xFF;
    tile.texel_y[k] = v & 0xFF;

    // Every lane looks at another point of the light.
    lx += view.light_radius * kPattern.light_x[k];
    ly += view.light_radius * kPattern.light_y[k];
    const float lift = kLift + 2e-4F * depth;
    to_light.org_x[k] = px + lift * nx;
    to_light.org_y[k] = py + lift * ny;
    to_light.org_z[k] = pz + lift * nz;
    to_light.dir_x[k] = lx;
    to_light.dir_y[k] = ly;
    to_light.dir_z[k] = lz;
    to_light.near[k] = 0.0F;
    to_light.far[k] = 0.98F;
    lit.on[k] = (tile.hit[k] != 0) & (facing > 0.0F) ? -1 : 0;
  }
}

EXTPERFC_LANES void look_around(const Tile& tile, RayPacket& packet, LaneMask& active) {
  Rays& rays = packet.ray;
#pragma omp simd
  for (int k = 0; k < kLanes; ++k) {
    const float nx = tile.normal[0][k];
    const float ny = tile.normal[1][k];
    const float nz = tile.normal[2][k];
    // Two axes that complete the normal to a frame, without a branch (Duff et al., "Building an orthonormal
    // basis, revisited", 2017).
    const float sign = nz >= 0.0F ? 1.0F : -1.0F;
    const float a = -1.0F / (sign + nz);
    const float b = nx * ny * a;
    const float s = kPattern.around[0][k];
    const float t = kPattern.around[1][k];
    const float c = kPattern.around[2][k];
    const float lift = 1e-3F;
    rays.org_x[k] = tile.point[0][k] + lift * nx;
    rays.org_y[k] = tile.point[1][k] + lift * ny;
    rays.org_z[k] = tile.point[2][k] + lift * nz;
    rays.dir_x[k] = s * (1.0F + sign * nx * nx * a) + t * b + c * nx;
    rays.dir_y[k] = s * sign * b + t * (sign + ny * ny * a) + c * ny;
    rays.dir_z[k] = -s * sign * nx - t * ny + c * nz;
    rays.near[k] = 0.0F;
    rays.far[k] = kReach_m;
    packet.hit.mesh_instance[k] = packet.hit.geometry[k] = kNoHit;
    active.on[k] = tile.hit[k] & kPattern.asks[k];
  }
}

void fetch_textures(Tile& tile) {
  for (int k = 0; k < kLanes; ++k) {
    const std::uint32_t* const texture = tile.texture[k];
    for (int i = 0; i < 4; ++i) tile.pixel[i][k] = texture != nullptr ? texture[tile.texel[i][k]] : 0xFFFFFFU;
  }
}

EXTPERFC_LANES void reflect(Tile& tile) {
  for (int i = 0; i < 3; ++i) {
    const int shift = 8 * i;
#pragma omp simd
    for (int k = 0; k < kLanes; ++k) {
      const auto channel = [&](int corner) {
        return static_cast<float>(static_cast<std::int32_t>(tile.pixel[corner][k] >> shift & 0xFFU));
      };
      const float x = static_cast<float>(tile.texel_x[k]) * (1.0F / 256.0F);
      const float y = static_cast<float>(tile.texel_y[k]) * (1.0F / 256.0F);
      const float upper = channel(0) + x * (channel(1) - channel(0));
      const float lower = channel(2) + x * (channel(3) - channel(2));
      const float value = (upper + y * (lower - upper)) * (1.0F / 255.0F);
      const float albedo = tile.albedo[i][k] * value * value;
      tile.from_light[i][k] = albedo * tile.direct[k] + tile.highlight[k];
      tile.from_around[i][k] = albedo * tile.ambient[i][k] + tile.rim[k];
    }
  }
}

}  // namespace extperfc::simulate
