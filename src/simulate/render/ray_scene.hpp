#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "simulate/render/mesh.hpp"

// Embree's.
struct RTCDeviceTy;
struct RTCSceneTy;
struct RTCGeometryTy;

namespace extperfc::simulate {

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

/// Meshes that can be moved, and the rays that hit them, cast by Embree. One thread at a time.
class RayScene {
 public:
  /// Null when Embree does not run on this processor.
  [[nodiscard]] static std::unique_ptr<RayScene> make();
  ~RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;

  /// Returns the number of the mesh instance: 0, 1, 2, ... Triangles keep their order.
  std::uint32_t add(const Mesh& mesh);
  void place(std::uint32_t mesh_instance, const Placement& world_T_mesh);
  /// For rays with a time between 0 and 1 it is in between, until it is placed again; a placement of place()
  /// holds for all times.
  void place_moving(std::uint32_t mesh_instance, const Placement& at_time_0, const Placement& at_time_1);
  /// Makes what was added and placed visible to rays.
  void commit();

  /// Nearest hits; lanes that take no part stay as they are. `coherent`: the rays start at one point and have
  /// about the same direction, which is faster when all lanes take part.
  void intersect(const LaneMask& active, bool coherent, RayPacket& packet) const;
  /// Sets rays.far to -infinity where something lies between near and far.
  void occluded(const LaneMask& active, Rays& rays) const;

  [[nodiscard]] static const char* name();

 private:
  explicit RayScene(RTCDeviceTy* device);

  RTCDeviceTy* device_;
  RTCSceneTy* top_;
  std::vector<RTCGeometryTy*> instances_;
};

}  // namespace extperfc::simulate
