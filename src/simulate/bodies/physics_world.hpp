#pragma once

#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include "extperfc/simulate/bodies.hpp"

namespace extperfc::simulate {

/// What a collision object is; stored as its user index. Its user index 2 is the number within the kind.
enum class ObjectKind { kBody = 0, kPerson, kLink, kChassis };

/// Collision filter groups.
enum CollisionGroup : int {
  kStaticGroup = 1,  ///< fixed and movable bodies
  kLooseGroup = 2,
  kLinkGroup = 4,     ///< arms, hands, fingers, head
  kChassisGroup = 8,  ///< links that hang on the root by fixed joints
  kPersonGroup = 16,
};

/// Bullet's world with the settings that make it deterministic. Everything added must be removed before it
/// ends.
class PhysicsWorld {
 public:
  explicit PhysicsWorld(const BodiesParams& params);

  PhysicsWorld(const PhysicsWorld&) = delete;
  PhysicsWorld& operator=(const PhysicsWorld&) = delete;

  [[nodiscard]] btMultiBodyDynamicsWorld& bullet() { return world_; }
  [[nodiscard]] const btMultiBodyDynamicsWorld& bullet() const { return world_; }
  [[nodiscard]] double step_s() const { return step_s_; }
  /// Turns contacts between a link and a body on or off; those that are there already go.
  void set_contacts(const btCollisionObject& link, btRigidBody& body, bool on);
  void step() { world_.stepSimulation(step_s_, 0); }

 private:
  double step_s_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;
  btMultiBodyDynamicsWorld world_;
};

}  // namespace extperfc::simulate
