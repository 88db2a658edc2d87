#pragma once

#include <memory>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/world_spec.hpp"

#include "simulate/bodies/collision_shapes.hpp"
#include "simulate/bodies/kinematic_body.hpp"
#include "simulate/bodies/physics_world.hpp"

namespace extperfc::simulate {

/// Everything in the world that is not the robot: fixed, movable and loose bodies, people.
class Scenery {
 public:
  /// Errors: a loose body without mass, a pose or coefficient that is not finite, a shape Bullet cannot take.
  [[nodiscard]] static Result<std::unique_ptr<Scenery>> make(PhysicsWorld& world, const WorldSpec& spec);
  ~Scenery();

  Scenery(const Scenery&) = delete;
  Scenery& operator=(const Scenery&) = delete;

  [[nodiscard]] Pose world_T_body(int body) const;
  [[nodiscard]] Eigen::Vector3d velocity(int body) const;  ///< [m/s]
  [[nodiscard]] bool is_loose(int body) const { return objects_[body].mobility == Mobility::kLoose; }
  [[nodiscard]] btRigidBody& bullet(int body) { return *objects_[body].body; }
  /// Puts the body there, at rest, and wakes everything loose. Not for fixed bodies.
  void place(int body, const Pose& world_T_body);
  /// Gives a loose body the velocity that brings it there in one step, if nothing blocks it.
  void drive(int body, const Pose& world_T_body);
  [[nodiscard]] Mobility mobility(int body) const { return objects_[body].mobility; }
  [[nodiscard]] int size() const { return static_cast<int>(objects_.size()); }

  void aim_person(int person, const Pose2& pose);
  [[nodiscard]] int people() const { return static_cast<int>(people_.size()); }
  /// Around every step.
  void before_step();
  void after_step();

 private:
  struct Object {
    Mobility mobility{Mobility::kFixed};
    CollisionShape shape;
    Pose body_T_frame{Pose::Identity()};  // frame that Bullet moves: principal axes of inertia
    std::unique_ptr<btRigidBody> body;
  };

  explicit Scenery(PhysicsWorld& world) : world_(&world) {}
  Result<void> add(const BodySpec& spec);
  void wake_all();

  PhysicsWorld* world_;
  std::vector<Object> objects_;
  std::vector<std::unique_ptr<KinematicBody>> people_;
  std::vector<Pose> person_goals_;
};

}  // namespace extperfc::simulate
