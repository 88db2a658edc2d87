#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "simulate/render/bvh.hpp"
#include "simulate/render/ray_scene.hpp"

namespace extperfc::simulate::render {

namespace {

using Eigen::Vector3f;

struct Found {
  std::uint32_t mesh_instance{kNoHit};
  std::uint32_t triangle{kNoHit};
  float u{0}, v{0};
  Vector3f normal{Vector3f::Zero()};
};

/// Corner and edges of a triangle.
struct Facet {
  Vector3f corner, edge1, edge2;
};

/// Moller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997), both sides.
bool meets(const Facet& facet, BvhRay& ray, Found& found) {
  const Vector3f direction = ray.direction.matrix();
  const Vector3f p = direction.cross(facet.edge2);
  const float determinant = facet.edge1.dot(p);
  if (determinant == 0.0F) return false;
  const float inverse = 1.0F / determinant;
  const Vector3f to_origin = ray.origin.matrix() - facet.corner;
  const float u = to_origin.dot(p) * inverse;
  const Vector3f q = to_origin.cross(facet.edge1);
  const float v = direction.dot(q) * inverse;
  constexpr float kEdge = 1e-6F;  // rays along an edge shall not slip through
  if (u < -kEdge || v < -kEdge || u + v > 1.0F + kEdge) return false;
  const float t = facet.edge2.dot(q) * inverse;
  if (t < ray.near || t > ray.far) return false;
  ray.far = t;
  found.u = u;
  found.v = v;
  found.normal = facet.edge1.cross(facet.edge2);
  return true;
}

class MeshTree {
 public:
  explicit MeshTree(const Mesh& mesh) {
    std::vector<Bounds> boxes;
    boxes.reserve(mesh.triangles.size());
    facets_.reserve(mesh.triangles.size());
    for (const auto& triangle : mesh.triangles) {
      std::array<Vector3f, 3> corners;
      Bounds box;
      for (std::size_t i = 0; i < 3; ++i) {
        corners[i] = mesh.vertices[triangle.corners[i]].position;
        box.grow(corners[i].array());
      }
      facets_.push_back({corners[0], corners[1] - corners[0], corners[2] - corners[0]});
      boxes.push_back(box);
      bounds_.grow(box);
    }
    tree_.build(boxes);
  }

  [[nodiscard]] const Bounds& bounds() const { return bounds_; }

  /// True when something was hit; with `any` the first hit will do.
  bool cast(BvhRay& ray, bool any, Found& found) const {
    bool hit = false;
    tree_.walk(ray, [&](std::uint32_t triangle, BvhRay& r) {
      if (!meets(facets_[triangle], r, found)) return false;
      found.triangle = triangle;
      hit = true;
      return any;
    });
    return hit;
  }

 private:
  std::vector<Facet> facets_;
  Bvh tree_;
  Bounds bounds_;
};

class BvhScene final : public RayScene {
 public:
  std::uint32_t add(const Mesh& mesh) override {
    mesh_instances_.push_back({MeshTree(mesh), Eigen::Affine3f::Identity(), Eigen::Affine3f::Identity()});
    return static_cast<std::uint32_t>(mesh_instances_.size() - 1);
  }

  void place(std::uint32_t mesh_instance, const Placement& world_T_mesh) override {
    auto& p = mesh_instances_[mesh_instance];
    p.world_T_mesh.affine() = Eigen::Map<const Eigen::Matrix<float, 3, 4>>(world_T_mesh.data());
    p.mesh_T_world = p.world_T_mesh.inverse();
  }

  void commit() override {
    std::vector<Bounds> boxes(mesh_instances_.size());
    for (std::size_t i = 0; i < mesh_instances_.size(); ++i) {
      const auto& box = mesh_instances_[i].mesh.bounds();
      for (int corner = 0; corner < 8; ++corner) {
        const Vector3f at((corner & 1) != 0 ? box.high.x() : box.low.x(),
                          (corner & 2) != 0 ? box.high.y() : box.low.y(),
                          (corner & 4) != 0 ? box.high.z() : box.low.z());
        boxes[i].grow((mesh_instances_[i].world_T_mesh * at).array());
      }
    }
    top_.build(boxes);
  }

  void intersect(const LaneMask& active, bool /*coherent*/, RayPacket& packet) const override {
    for (int k = 0; k < kLanes; ++k) {
      if (active.on[k] == 0) continue;
      Found found;
      BvhRay ray = lane(packet.ray, k);
      cast(ray, false, found);
      if (found.mesh_instance == kNoHit) continue;
      packet.ray.far[k] = ray.far;
      packet.hit.normal_x[k] = found.normal.x();
      packet.hit.normal_y[k] = found.normal.y();
      packet.hit.normal_z[k] = found.normal.z();
      packet.hit.u[k] = found.u;
      packet.hit.v[k] = found.v;
      packet.hit.triangle[k] = found.triangle;
      packet.hit.geometry[k] = 0;
      packet.hit.mesh_instance[k] = found.mesh_instance;
    }
  }

  void occluded(const LaneMask& active, Rays& rays) const override {
    for (int k = 0; k < kLanes; ++k) {
      if (active.on[k] == 0) continue;
      Found found;
      BvhRay ray = lane(rays, k);
      cast(ray, true, found);
      if (found.mesh_instance != kNoHit) rays.far[k] = -std::numeric_limits<float>::infinity();
    }
  }

  [[nodiscard]] const char* name() const override { return "own BVH"; }

 private:
  struct MeshInstance {
    MeshTree mesh;
    Eigen::Affine3f world_T_mesh, mesh_T_world;
  };

  static BvhRay lane(const Rays& rays, int k) {
    return {{rays.org_x[k], rays.org_y[k], rays.org_z[k]},
            {rays.dir_x[k], rays.dir_y[k], rays.dir_z[k]},
            rays.near[k],
            rays.far[k]};
  }

  void cast(BvhRay& ray, bool any, Found& found) const {
    top_.walk(ray, [&](std::uint32_t mesh_instance, BvhRay& r) {
      const auto& p = mesh_instances_[mesh_instance];
      BvhRay local((p.mesh_T_world * r.origin.matrix()).array(),
                   (p.mesh_T_world.linear() * r.direction.matrix()).array(), r.near, r.far);
      if (!p.mesh.cast(local, any, found)) return false;
      r.far = local.far;
      found.mesh_instance = mesh_instance;
      return any;
    });
  }

  std::vector<MeshInstance> mesh_instances_;
  Bvh top_;
};

}  // namespace

std::unique_ptr<RayScene> make_bvh_scene() {
  return std::make_unique<BvhScene>();
}

}  // namespace extperfc::simulate::render
