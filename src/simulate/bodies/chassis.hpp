#pragma once

#include <memory>

#include "extperfc/base/error.hpp"

#include "simulate/bodies/kinematic_body.hpp"
#include "simulate/bodies/robot_body.hpp"

namespace extperfc::simulate {

/// The links that hang on the robot's root by fixed joints, and its wheels: pushes loose bodies, and reports
/// where it would hit something that it cannot push.
class Chassis {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Chassis>> make(PhysicsWorld& world, const RobotPlan& plan,
                                                             const Pose& world_T_root);

  [[nodiscard]] KinematicBody& body() { return *body_; }
  /// True when it would overlap a fixed or movable body or a person by more than 2 mm there.
  [[nodiscard]] bool collides(const Pose& world_T_root);

 private:
  explicit Chassis(PhysicsWorld& world) : world_(&world) {}

  PhysicsWorld* world_;
  CollisionShape probe_shape_;
  btCollisionObject probe_;  // never in the world
  std::unique_ptr<KinematicBody> body_;
};

}  // namespace extperfc::simulate
