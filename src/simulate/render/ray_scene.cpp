#include "simulate/render/ray_scene.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>

#include <embree3/rtcore.h>

namespace extperfc::simulate {

namespace {

// Packets are handed over in place.
static_assert(sizeof(Rays) == sizeof(RTCRay16) && sizeof(Hits) == sizeof(RTCHit16));
static_assert(offsetof(Rays, near) == offsetof(RTCRay16, tnear) &&
              offsetof(Rays, dir_x) == offsetof(RTCRay16, dir_x) &&
              offsetof(Rays, time) == offsetof(RTCRay16, time) &&
              offsetof(Rays, far) == offsetof(RTCRay16, tfar) &&
              offsetof(Rays, mask) == offsetof(RTCRay16, mask) &&
              offsetof(Rays, flags) == offsetof(RTCRay16, flags));
static_assert(offsetof(Hits, u) == offsetof(RTCHit16, u) && offsetof(Hits, v) == offsetof(RTCHit16, v) &&
              offsetof(Hits, triangle) == offsetof(RTCHit16, primID) &&
              offsetof(Hits, geometry) == offsetof(RTCHit16, geomID) &&
              offsetof(Hits, mesh_instance) == offsetof(RTCHit16, instID) &&
              RTC_INVALID_GEOMETRY_ID == kNoHit);

void attach_triangles(RTCDevice device, RTCScene bottom, const Mesh& mesh) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* corner = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size()));
  for (const auto& vertex : mesh.vertices) corner = std::copy_n(vertex.position.data(), 3, corner);
  auto* index = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t),
                              mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles)
    index = std::copy(triangle.corners.begin(), triangle.corners.end(), index);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(bottom, geometry);
  rtcReleaseGeometry(geometry);
}

/// What a cast may change of lane k, as it was.
void restore(const RayPacket& before, int k, RayPacket& packet) {
  packet.ray.far[k] = before.ray.far[k];
  const Hits& from = before.hit;
  Hits& to = packet.hit;
  to.normal_x[k] = from.normal_x[k];
  to.normal_y[k] = from.normal_y[k];
  to.normal_z[k] = from.normal_z[k];
  to.u[k] = from.u[k];
  to.v[k] = from.v[k];
  to.triangle[k] = from.triangle[k];
  to.geometry[k] = from.geometry[k];
  to.mesh_instance[k] = from.mesh_instance[k];
}

}  // namespace

void clear(Rays& rays) {
  for (int k = 0; k < kLanes; ++k) {
    rays.org_x[k] = rays.org_y[k] = rays.org_z[k] = 0.0F;
    rays.dir_x[k] = rays.dir_y[k] = 0.0F;
    rays.dir_z[k] = 1.0F;
    rays.near[k] = rays.far[k] = rays.time[k] = 0.0F;
    rays.mask[k] = 0xFFFFFFFFU;
    rays.id[k] = rays.flags[k] = 0U;
  }
}

void clear(Hits& hits) {
  for (int k = 0; k < kLanes; ++k) {
    hits.normal_x[k] = hits.normal_y[k] = hits.normal_z[k] = 0.0F;
    hits.u[k] = hits.v[k] = 0.0F;
    hits.triangle[k] = hits.geometry[k] = hits.mesh_instance[k] = kNoHit;
  }
}

std::unique_ptr<RayScene> RayScene::make() {
  // No number of threads: Embree would set it as TBB's for the whole process. Inference beside the simulator
  // then has a single thread, and the tasks that OpenVINO meant for others pile up (10 MB a minute).
  RTCDevice device = rtcNewDevice("set_affinity=0");
  return device == nullptr ? nullptr : std::unique_ptr<RayScene>(new RayScene(device));
}

RayScene::RayScene(RTCDeviceTy* device) : device_(device), top_(rtcNewScene(device)) {
  rtcSetSceneFlags(top_, RTC_SCENE_FLAG_DYNAMIC);
}

RayScene::~RayScene() {
  rtcReleaseScene(top_);
  rtcReleaseDevice(device_);
}

std::uint32_t RayScene::add(const Mesh& mesh) {
  RTCScene bottom = rtcNewScene(device_);
  rtcSetSceneFlags(bottom, RTC_SCENE_FLAG_ROBUST);  // without it, single rays slip between triangles
  rtcSetSceneBuildQuality(bottom, RTC_BUILD_QUALITY_HIGH);
  attach_triangles(device_, bottom, mesh);
  rtcCommitScene(bottom);
  RTCGeometry instance = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(instance, bottom);
  rtcReleaseScene(bottom);  // the instance holds it now
  const auto mesh_instance = static_cast<std::uint32_t>(instances_.size());
  rtcAttachGeometryByID(top_, instance, mesh_instance);
  rtcReleaseGeometry(instance);  // the top scene holds it
  instances_.push_back(instance);
  place(mesh_instance, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  return mesh_instance;
}

void RayScene::place(std::uint32_t mesh_instance, const Placement& world_T_mesh) {
  rtcSetGeometryTimeStepCount(instances_[mesh_instance], 1);
  rtcSetGeometryTransform(instances_[mesh_instance], 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                          world_T_mesh.data());
  rtcCommitGeometry(instances_[mesh_instance]);
}

void RayScene::place_moving(std::uint32_t mesh_instance, const Placement& at_time_0,
                            const Placement& at_time_1) {
  const auto instance = instances_[mesh_instance];
  rtcSetGeometryTimeStepCount(instance, 2);
  rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, at_time_0.data());
  rtcSetGeometryTransform(instance, 1, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, at_time_1.data());
  rtcCommitGeometry(instance);
}

void RayScene::commit() {
  rtcCommitScene(top_);
}

void RayScene::intersect(const LaneMask& active, bool coherent, RayPacket& packet) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  const bool whole = std::find(std::begin(active.on), std::end(active.on), 0) == std::end(active.on);
  if (coherent && whole) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  auto* rays = reinterpret_cast<RTCRayHit16*>(&packet);
  if (whole) {
    rtcIntersect16(active.on, top_, &context, rays);
    return;
  }
  // With AVX-512, Embree 3.13.5 writes hits to lanes that take no part.
  const RayPacket before = packet;
  rtcIntersect16(active.on, top_, &context, rays);
  for (int k = 0; k < kLanes; ++k)
    if (active.on[k] == 0) restore(before, k, packet);
}

void RayScene::occluded(const LaneMask& active, Rays& rays) const {
  // Never coherent: with that flag Embree 3.13.5 does not come back on AVX-512.
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded16(active.on, top_, &context, reinterpret_cast<RTCRay16*>(&rays));
}

const char* RayScene::name() {
  return "Embree " RTC_VERSION_STRING ", 16-wide";
}

}  // namespace extperfc::simulate
