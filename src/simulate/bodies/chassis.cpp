#include "simulate/bodies/chassis.hpp"

#include <utility>
#include <vector>

#include "simulate/bodies/bullet_conversions.hpp"

namespace extperfc::simulate {
namespace {

constexpr double kAllowedOverlap = 0.002;  // [m]
constexpr double kFloorHeight = 0.03;      // [m]; what is lower, the wheels pass over

/// Collects what cannot be pushed and reaches above the floor.
struct Obstacles : btBroadphaseAabbCallback {
  std::vector<btCollisionObject*> found;

  bool process(const btBroadphaseProxy* proxy) override {
    const bool counts = (proxy->m_collisionFilterGroup & (kStaticGroup | kPersonGroup)) != 0;
    if (counts && proxy->m_aabbMax.z() > kFloorHeight)
      found.push_back(static_cast<btCollisionObject*>(proxy->m_clientObject));
    return true;
  }
};

struct DeepContact : btCollisionWorld::ContactResultCallback {
  bool found{false};

  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* /*a*/, int /*part_a*/,
                           int /*index_a*/, const btCollisionObjectWrapper* /*b*/, int /*part_b*/,
                           int /*index_b*/) override {
    found = found || point.getDistance() < -kAllowedOverlap;
    return 0;
  }
};

}  // namespace

Result<std::unique_ptr<Chassis>> Chassis::make(PhysicsWorld& world, const RobotPlan& plan,
                                               const Pose& world_T_root) {
  const RigidGroup& root = plan.tree.groups.front();
  const std::string name = "link " + plan.model->links().front().name;
  auto shape = CollisionShape::make(name, root.collisions, Pose::Identity());
  if (!shape) return tl::unexpected<Error>(shape.error());
  auto probe = CollisionShape::make(name, root.collisions, Pose::Identity());
  if (!probe) return tl::unexpected<Error>(probe.error());
  std::unique_ptr<Chassis> chassis(new Chassis(world));
  chassis->probe_shape_ = std::move(*probe);
  chassis->probe_.setCollisionShape(chassis->probe_shape_.get());
  chassis->body_ =
      std::make_unique<KinematicBody>(world, std::move(*shape), world_T_root, ObjectKind::kChassis, 0,
                                      kChassisGroup, root.collisions.empty() ? 0 : kLooseGroup);
  return chassis;
}

bool Chassis::collides(const Pose& world_T_root) {
  probe_.setWorldTransform(to_bullet(world_T_root));
  btVector3 low;
  btVector3 high;
  probe_shape_.get()->getAabb(probe_.getWorldTransform(), low, high);
  Obstacles obstacles;
  world_->bullet().getBroadphase()->aabbTest(low, high, obstacles);
  for (btCollisionObject* const obstacle : obstacles.found) {
    DeepContact contact;
    world_->bullet().contactPairTest(&probe_, obstacle, contact);
    if (contact.found) return true;
  }
  return false;
}

}  // namespace extperfc::simulate
