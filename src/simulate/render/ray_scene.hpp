#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "simulate/render/mesh.hpp"

namespace extperfc::simulate::render {

inline constexpr int kLanes = 16;
inline constexpr std::uint32_t kNoHit = 0xFFFFFFFFU;

/// Sixteen rays, structure of arrays. Directions need not have unit length: distances are in their lengths.
/// The layout is the one that Embree works on in place.
struct alignas(64) Rays {
  float org_x[kLanes], org_y[kLanes], org_z[kLanes];
  float near[kLanes];
  float dir_x[kLanes], dir_y[kLanes], dir_z[kLanes];
  float time[kLanes];
  float far[kLanes];  ///< in: how far to look; out: distance of the hit, or -infinity when occluded
  std::uint32_t mask[kLanes], id[kLanes], flags[kLanes];
};

struct alignas(64) Hits {
  float normal_x[kLanes], normal_y[kLanes], normal_z[kLanes];
  float u[kLanes], v[kLanes];  ///< weights of the triangle's second and third corner
  std::uint32_t triangle[kLanes];
  std::uint32_t geometry[kLanes];
  std::uint32_t mesh_instance[kLanes];  ///< kNoHit: nothing was hit
};

struct RayPacket {
  Rays ray;
  Hits hit;
};

/// -1: the lane takes part, 0: it does not.
struct alignas(64) LaneMask {
  std::int32_t on[kLanes];
};

/// Every lane, active or not, to a state that an engine can work on: a ray that ends where it starts.
void clear(Rays& rays);
void clear(Hits& hits);

/// Column-major 3 x 4: where a mesh instance is in the world.
using Placement = std::array<float, 12>;

/// Meshes that can be moved, and the rays that hit them. One thread at a time.
class RayScene {
 public:
  virtual ~RayScene() = default;

  /// Returns the number of the mesh instance: 0, 1, 2, ... Triangles keep their order.
  virtual std::uint32_t add(const Mesh& mesh) = 0;
  virtual void place(std::uint32_t mesh_instance, const Placement& world_T_mesh) = 0;
  /// Makes what was added and placed visible to rays.
  virtual void commit() = 0;

  /// Nearest hits. `coherent`: the rays start at one point and have about the same direction, which is
  /// faster.
  virtual void intersect(const LaneMask& active, bool coherent, RayPacket& packet) const = 0;
  /// Sets rays.far to -infinity where something lies between near and far.
  virtual void occluded(const LaneMask& active, Rays& rays) const = 0;

  [[nodiscard]] virtual const char* name() const = 0;
};

/// Null when this build or machine has no Embree.
[[nodiscard]] std::unique_ptr<RayScene> make_embree_scene();
/// Two-level bounding-volume tree without libraries; runs everywhere.
[[nodiscard]] std::unique_ptr<RayScene> make_bvh_scene();
/// The fastest that there is.
[[nodiscard]] std::unique_ptr<RayScene> make_ray_scene();

}  // namespace extperfc::simulate::render
