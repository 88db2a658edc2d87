#include "simulate/render/ray_scene.hpp"

#ifdef EXTPERFC_EMBREE

#include <algorithm>
#include <cstddef>

#include <embree3/rtcore.h>

namespace extperfc::simulate::render {

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

class EmbreeScene final : public RayScene {
 public:
  explicit EmbreeScene(RTCDevice device) : device_(device), top_(rtcNewScene(device)) {
    rtcSetSceneFlags(top_, RTC_SCENE_FLAG_DYNAMIC);
  }
  ~EmbreeScene() override {
    rtcReleaseScene(top_);
    rtcReleaseDevice(device_);
  }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  std::uint32_t add(const Mesh& mesh) override {
    RTCScene bottom = rtcNewScene(device_);
    rtcSetSceneFlags(bottom, RTC_SCENE_FLAG_ROBUST);  // without it, single rays slip between triangles
    rtcSetSceneBuildQuality(bottom, RTC_BUILD_QUALITY_HIGH);
    attach_triangles(bottom, mesh);
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

  void place(std::uint32_t mesh_instance, const Placement& world_T_mesh) override {
    rtcSetGeometryTransform(instances_[mesh_instance], 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                            world_T_mesh.data());
    rtcCommitGeometry(instances_[mesh_instance]);
  }

  void commit() override { rtcCommitScene(top_); }

  void intersect(const LaneMask& active, bool coherent, RayPacket& packet) const override {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(active.on, top_, &context, reinterpret_cast<RTCRayHit16*>(&packet));
  }

  void occluded(const LaneMask& active, Rays& rays) const override {
    // Never coherent: with that flag Embree 3.13.5 does not come back on AVX-512.
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded16(active.on, top_, &context, reinterpret_cast<RTCRay16*>(&rays));
  }

  [[nodiscard]] const char* name() const override { return "Embree " RTC_VERSION_STRING ", 16-wide"; }

 private:
  void attach_triangles(RTCScene bottom, const Mesh& mesh) {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* corner = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size()));
    for (const auto& vertex : mesh.vertices) corner = std::copy_n(vertex.position.data(), 3, corner);
    auto* index = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(std::uint32_t), mesh.triangles.size()));
    for (const auto& triangle : mesh.triangles)
      index = std::copy(triangle.corners.begin(), triangle.corners.end(), index);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(bottom, geometry);
    rtcReleaseGeometry(geometry);
  }

  RTCDevice device_;
  RTCScene top_;
  std::vector<RTCGeometry> instances_;
};

}  // namespace

std::unique_ptr<RayScene> make_embree_scene() {
  // No number of threads: Embree would set it as TBB's for the whole process. Inference beside the simulator
  // then has a single thread, and the tasks that OpenVINO meant for others pile up (10 MB a minute).
  RTCDevice device = rtcNewDevice("set_affinity=0");
  if (device == nullptr) return nullptr;
  return std::make_unique<EmbreeScene>(device);
}

}  // namespace extperfc::simulate::render

#else

namespace extperfc::simulate::render {

std::unique_ptr<RayScene> make_embree_scene() {
  return nullptr;
}

}  // namespace extperfc::simulate::render

#endif
