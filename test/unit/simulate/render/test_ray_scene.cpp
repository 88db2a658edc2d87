// Both ray engines: hits where geometry says, the same hits, and no gaps.

#include <cmath>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "simulate/render/mesh.hpp"
#include "simulate/render/ray_scene.hpp"

namespace extperfc::simulate::render {
namespace {

constexpr LaneMask kAllLanes{{-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1}};

Mesh mesh_of(const Geometry& geometry) {
  return make_mesh(geometry, {}, 0).value();
}

Placement shifted(float x, float y, float z) {
  return {1, 0, 0, 0, 1, 0, 0, 0, 1, x, y, z};
}

/// Rays from within a ball of radius `spread`, in all directions.
RayPacket random_rays(Rng& rng, double spread) {
  RayPacket packet{};
  clear(packet.ray);
  clear(packet.hit);
  for (int k = 0; k < kLanes; ++k) {
    const Eigen::Vector3d from =
        spread * Eigen::Vector3d(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    const Eigen::Vector3d along(rng.normal(0, 1), rng.normal(0, 1), rng.normal(0, 1));
    packet.ray.org_x[k] = static_cast<float>(from.x());
    packet.ray.org_y[k] = static_cast<float>(from.y());
    packet.ray.org_z[k] = static_cast<float>(from.z());
    packet.ray.dir_x[k] = static_cast<float>(along.normalized().x());
    packet.ray.dir_y[k] = static_cast<float>(along.normalized().y());
    packet.ray.dir_z[k] = static_cast<float>(along.normalized().z());
    packet.ray.far[k] = 100;
  }
  return packet;
}

std::unique_ptr<RayScene> engine(const std::string& name) {
  return name == "bvh" ? make_bvh_scene() : make_embree_scene();
}

class Engine : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    scene_ = engine(GetParam());
    if (scene_ == nullptr) GTEST_SKIP() << "built without Embree";
  }
  std::unique_ptr<RayScene> scene_;
};

TEST_P(Engine, FindsTheNearestInstanceWhereItWasPut) {
  const auto near = scene_->add(mesh_of(Box{{1, 1, 1}}));
  const auto far = scene_->add(mesh_of(Box{{1, 4, 4}}));
  scene_->place(near, shifted(3, 0, 0));
  scene_->place(far, shifted(8, 0, 0));
  scene_->commit();
  RayPacket packet{};
  clear(packet.ray);
  clear(packet.hit);
  for (int k = 0; k < kLanes; ++k) {
    packet.ray.org_y[k] = k < 8 ? 0.1F : 1.2F;  // the second half passes the near box
    packet.ray.dir_x[k] = 1;
    packet.ray.dir_z[k] = 0;
    packet.ray.far[k] = 100;
  }
  LaneMask active = kAllLanes;
  active.on[3] = 0;
  scene_->intersect(active, true, packet);
  for (int k = 0; k < kLanes; ++k) {
    if (k == 3) {
      EXPECT_EQ(packet.hit.mesh_instance[k], kNoHit);
      continue;
    }
    EXPECT_EQ(packet.hit.mesh_instance[k], k < 8 ? near : far) << "lane " << k;
    EXPECT_NEAR(packet.ray.far[k], k < 8 ? 2.5F : 7.5F, 1e-5F) << "lane " << k;
  }
}

TEST_P(Engine, OccludedOnlyBetweenNearAndFar) {
  scene_->place(scene_->add(mesh_of(Box{{1, 1, 1}})), shifted(3, 0, 0));
  scene_->commit();
  Rays rays{};
  clear(rays);
  for (int k = 0; k < kLanes; ++k) {
    rays.dir_x[k] = 1;
    rays.dir_z[k] = 0;
    rays.near[k] = k == 1 ? 4.0F : 0.0F;  // starts behind the box
    rays.far[k] = k == 2 ? 2.4F : 10.0F;  // ends before it
  }
  scene_->occluded(kAllLanes, rays);
  for (int k = 0; k < kLanes; ++k) EXPECT_EQ(rays.far[k] < 0, k != 1 && k != 2) << "lane " << k;
}

TEST_P(Engine, MovedInstancesAreSeenWhereTheyAreAfterCommit) {
  const auto ball = scene_->add(mesh_of(Sphere{0.5}));
  scene_->commit();
  for (const float x : {2.0F, 5.0F, 3.0F}) {
    scene_->place(ball, shifted(x, 0, 0));
    scene_->commit();
    RayPacket packet{};
    clear(packet.ray);
    clear(packet.hit);
    packet.ray.dir_x[0] = 1;
    packet.ray.dir_z[0] = 0;
    packet.ray.far[0] = 100;
    LaneMask first{};
    first.on[0] = -1;
    scene_->intersect(first, false, packet);
    EXPECT_NEAR(packet.ray.far[0], x - 0.5F, 0.002F);
  }
}

TEST_P(Engine, NoRayLeavesAClosedRoom) {
  // Many triangles: a sphere around everything, with boxes inside whose edges may leak too.
  scene_->add(mesh_of(Sphere{3.0}));
  for (int i = 0; i < 6; ++i)
    scene_->place(scene_->add(mesh_of(Box{{0.3, 0.4, 0.5}})),
                  shifted(static_cast<float>(i) * 0.35F - 1, 1.2F, 0.1F));
  scene_->commit();
  Rng rng(5);
  for (int i = 0; i < 6000; ++i) {
    auto packet = random_rays(rng, 0.5);
    scene_->intersect(kAllLanes, false, packet);
    for (int k = 0; k < kLanes; ++k)
      ASSERT_NE(packet.hit.mesh_instance[k], kNoHit) << "packet " << i << ", lane " << k;
  }
}

INSTANTIATE_TEST_SUITE_P(Both, Engine, testing::Values("embree", "bvh"),
                         [](const auto& one) { return one.param; });

class Agreement : public testing::Test {
 protected:
  void SetUp() override {
    if (embree_ == nullptr) GTEST_SKIP() << "built without Embree";
    Rng rng(7);
    for (const Geometry& geometry : {Geometry(Sphere{0.4}), Geometry(Cone{0.3, 0.8}),
                                     Geometry(Cylinder{0.3, 0.9}), Geometry(Box{{6, 6, 0.1}})}) {
      const Placement placement = random_placement(rng);
      for (auto* scene : {embree_.get(), bvh_.get()}) scene->place(scene->add(mesh_of(geometry)), placement);
    }
    embree_->commit();
    bvh_->commit();
  }

  static Placement random_placement(Rng& rng) {
    const Pose pose = make_pose({rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(-2, 2)},
                                {rng.uniform(-3, 3), rng.uniform(-1, 1), rng.uniform(-3, 3)});
    Placement placement{};
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 3; ++row)
        placement[static_cast<std::size_t>(3 * column + row)] =
            static_cast<float>(pose.matrix()(row, column));
    return placement;
  }

  std::unique_ptr<RayScene> embree_{make_embree_scene()};
  std::unique_ptr<RayScene> bvh_{make_bvh_scene()};
};

TEST_F(Agreement, SameHitsOnTheSameRays) {
  Rng rng(11);
  int hits = 0;
  int differing = 0;
  for (int i = 0; i < 1000; ++i) {
    auto a = random_rays(rng, 4.0);
    auto b = a;
    embree_->intersect(kAllLanes, false, a);
    bvh_->intersect(kAllLanes, false, b);
    for (int k = 0; k < kLanes; ++k) {
      hits += a.hit.mesh_instance[k] != kNoHit ? 1 : 0;
      if (a.hit.mesh_instance[k] != b.hit.mesh_instance[k]) {
        ++differing;  // grazes a silhouette
        continue;
      }
      if (a.hit.mesh_instance[k] == kNoHit) continue;
      ASSERT_NEAR(a.ray.far[k], b.ray.far[k], 1e-4F * (1 + a.ray.far[k]));
      if (a.hit.triangle[k] != b.hit.triangle[k]) continue;  // on an edge both are right
      ASSERT_NEAR(a.hit.u[k], b.hit.u[k], 2e-3F);
      ASSERT_NEAR(a.hit.v[k], b.hit.v[k], 2e-3F);
    }
  }
  EXPECT_GT(hits, 2000);
  EXPECT_LE(differing, 3);
}

TEST_F(Agreement, SameOcclusion) {
  Rng rng(13);
  int differing = 0;
  for (int i = 0; i < 500; ++i) {
    auto a = random_rays(rng, 4.0).ray;
    for (float& far : a.far) far = 3;
    auto b = a;
    embree_->occluded(kAllLanes, a);
    bvh_->occluded(kAllLanes, b);
    for (int k = 0; k < kLanes; ++k) differing += (a.far[k] < 0) != (b.far[k] < 0) ? 1 : 0;
  }
  EXPECT_LE(differing, 3);
}

}  // namespace
}  // namespace extperfc::simulate::render
