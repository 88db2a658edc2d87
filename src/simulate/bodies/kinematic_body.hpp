#pragma once

#include <memory>

#include "simulate/bodies/collision_shapes.hpp"
#include "simulate/bodies/physics_world.hpp"

namespace extperfc::simulate {

/// A body that follows commanded poses and pushes loose ones with its velocity.
class KinematicBody {
 public:
  KinematicBody(PhysicsWorld& world, CollisionShape shape, const Pose& world_T_body, ObjectKind kind,
                int number, int group, int mask);
  ~KinematicBody();

  KinematicBody(const KinematicBody&) = delete;
  KinematicBody& operator=(const KinematicBody&) = delete;

  /// Before a step: where the body is at its end.
  void aim(const Pose& world_T_body);
  /// After the step: it is there.
  void arrive();
  /// There at once, at rest.
  void place(const Pose& world_T_body);

  [[nodiscard]] btRigidBody& bullet() { return *body_; }
  [[nodiscard]] const btRigidBody& bullet() const { return *body_; }

 private:
  PhysicsWorld* world_;
  CollisionShape shape_;
  std::unique_ptr<btRigidBody> body_;
  btTransform end_;
};

}  // namespace extperfc::simulate
