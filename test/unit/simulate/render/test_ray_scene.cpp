// Rays hit where geometry says, and find no gaps.

#include <memory>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "simulate/render/mesh.hpp"
#include "simulate/render/ray_scene.hpp"

namespace extperfc::simulate {
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

class RaySceneTest : public testing::Test {
 protected:
  void SetUp() override { ASSERT_NE(scene_, nullptr) << "Embree does not run on this processor"; }

  std::unique_ptr<RayScene> scene_ = RayScene::make();
};

TEST_F(RaySceneTest, FindsTheNearestInstanceWhereItWasPut) {
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

TEST_F(RaySceneTest, OccludedOnlyBetweenNearAndFar) {
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

TEST_F(RaySceneTest, MovedInstancesAreSeenWhereTheyAreAfterCommit) {
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

TEST_F(RaySceneTest, NoRayLeavesAClosedRoom) {
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

TEST_F(RaySceneTest, WeightsOfTheCornersGiveThePointThatTheRayMeets) {
  const Mesh ball = mesh_of(Sphere{3.0});
  scene_->add(ball);
  scene_->commit();
  Rng rng(11);
  for (int i = 0; i < 200; ++i) {
    auto packet = random_rays(rng, 1.0);
    const Rays rays = packet.ray;
    scene_->intersect(kAllLanes, false, packet);
    for (int k = 0; k < kLanes; ++k) {
      ASSERT_LT(packet.hit.triangle[k], ball.triangles.size());
      const auto& corners = ball.triangles[packet.hit.triangle[k]].corners;
      const float u = packet.hit.u[k];
      const float v = packet.hit.v[k];
      const Eigen::Vector3f met = (1 - u - v) * ball.vertices[corners[0]].position +
                                  u * ball.vertices[corners[1]].position +
                                  v * ball.vertices[corners[2]].position;
      const Eigen::Vector3f from(rays.org_x[k], rays.org_y[k], rays.org_z[k]);
      const Eigen::Vector3f along(rays.dir_x[k], rays.dir_y[k], rays.dir_z[k]);
      ASSERT_LT((from + packet.ray.far[k] * along - met).norm(), 1e-3F) << "packet " << i << ", lane " << k;
    }
  }
}

}  // namespace
}  // namespace extperfc::simulate
