#pragma once

#include <cstdint>

#include "extperfc/world/pose.hpp"

#include "simulate/render/ray_scene.hpp"
#include "simulate/render/scene.hpp"

/// Light on sixteen surface points at a time. A packet is a tile of 4 x 4 pixels; lane k is column k % 4, row
/// k / 4 of it.
namespace extperfc::simulate {

/// Camera and light of one image.
struct View {
  float origin[3];
  float right[3], down[3], forward[3];  ///< axes of the optical frame in the world
  float near, far;                      ///< depths that are seen [m]
  float pixel_width;                    ///< at a depth of 1 m [m]
  float light[3];                       ///< position [m]
  float light_radius;                   ///< [m]; 0: sharp shadows
  float direct_weight, ambient_weight;  ///< of the light
  float sky[3];                         ///< linear
  float background[3];                  ///< what is seen where nothing is hit, linear
};

[[nodiscard]] View make_view(const Pose& world_T_optical, const LightSpec& light, double fx, bool soft);

/// What is known of the points that a packet has hit, in world coordinates. Lanes without a hit hold harmless
/// values.
struct alignas(64) Tile {
  std::int32_t hit[kLanes];  ///< -1: yes
  float point[3][kLanes];
  float normal[3][kLanes];  ///< unit, towards the camera
  float albedo[3][kLanes];  ///< linear
  float gloss[kLanes];
  float texture_u[kLanes], texture_v[kLanes];
  float pixels_per_m[kLanes];                     ///< of the texture
  std::int32_t texel[4][kLanes];                  ///< indices of the four nearest pixels of the texture
  std::int32_t texel_x[kLanes], texel_y[kLanes];  ///< place between them, 1/256
  std::uint32_t pixel[4][kLanes];                 ///< their colours
  const std::uint32_t* texture[kLanes];           ///< pixels; null: none
  std::uint16_t instance[kLanes];
  float direct[kLanes];          ///< direct light where nothing blocks it
  float highlight[kLanes];       ///< its mirror image
  float ambient[3][kLanes];      ///< light from all around
  float rim[kLanes];             ///< its mirror image
  float from_light[3][kLanes];   ///< direct light that is reflected, linear
  float from_around[3][kLanes];  ///< ambient light that is reflected, linear
};

/// Rays through the pixels of a tile; `slopes` holds 16 x/z and 16 y/z.
void aim(const View& view, const float* slopes, RayPacket& packet);

/// Surfaces of the hits.
void gather(const Scene& scene, const RayPacket& packet, Tile& tile);

/// Light on the hits, and rays from them to points of the light.
void light(const View& view, const RayPacket& packet, Tile& tile, Rays& to_light, LaneMask& lit);

inline constexpr float kReach_m = 0.6F;  ///< how far away objects still take ambient light

/// Rays of the length kReach_m into the half space above each hit, in every second lane.
void look_around(const Tile& tile, RayPacket& packet, LaneMask& active);

/// Fetches the pixels of the textures that light() has chosen.
void fetch_textures(Tile& tile);

/// What comes back of the light, textures included.
void reflect(Tile& tile);

}  // namespace extperfc::simulate
