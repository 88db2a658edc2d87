#include "simulate/render/ray_scene.hpp"

namespace extperfc::simulate::render {

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

std::unique_ptr<RayScene> make_ray_scene() {
  auto scene = make_embree_scene();
  return scene != nullptr ? std::move(scene) : make_bvh_scene();
}

}  // namespace extperfc::simulate::render
