#pragma once

#include <memory>
#include <vector>

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include "extperfc/base/error.hpp"

#include "simulate/bodies/collision_shapes.hpp"
#include "simulate/bodies/physics_world.hpp"
#include "simulate/bodies/robot_body.hpp"

namespace extperfc::simulate {

/// One tree of links on the robot's root: an arm with its gripper, or the head. Limbs are multibodies
/// (Featherstone), as a root that follows commanded poses takes no forces from one to another;
/// that makes each row of the constraint solver half as long as one multibody for the whole robot would.
class DynamicLimb {
 public:
  /// `groups`: of the limb, parents first; the first one hangs on the root.
  [[nodiscard]] static Result<std::unique_ptr<DynamicLimb>> make(PhysicsWorld& world, const RobotPlan& plan,
                                                                 std::vector<int> groups,
                                                                 const Pose& world_T_root,
                                                                 const std::vector<double>& positions);
  ~DynamicLimb();

  DynamicLimb(const DynamicLimb&) = delete;
  DynamicLimb& operator=(const DynamicLimb&) = delete;

  /// Index of a group's link; -1 when it belongs to another limb.
  [[nodiscard]] int link_of(int group) const;
  [[nodiscard]] int links() const { return static_cast<int>(groups_.size()); }
  [[nodiscard]] int group(int link) const { return groups_[link]; }
  [[nodiscard]] Pose world_T_group(int link) const;
  [[nodiscard]] const btCollisionObject& object(int link) const { return *colliders_[link]; }

  /// Before a step: what the joint shall do; `speed_limit` bounds the motor.
  void drive(int link, const Joint& joint, const JointTarget& target, double speed_limit);
  /// Before a step: a force on a link [N], at a point in the world.
  void push(int link, const btVector3& force_n, const btVector3& world_point);
  /// Before a step: the root's velocity towards its commanded pose.
  void aim_root(const Pose& world_T_root);
  /// After the step: the root is exactly there.
  void arrive_root();
  /// The root stands there now, at rest.
  void place_root(const Pose& world_T_root);

  [[nodiscard]] double position(int link) const { return body_->getJointPos(link); }
  [[nodiscard]] double velocity(int link) const { return body_->getJointVel(link); }
  [[nodiscard]] double effort(int link) const { return efforts_[link]; }

  /// Constraint that keeps a loose body where it is in the frame of a link.
  [[nodiscard]] std::unique_ptr<btMultiBodyConstraint> weld(int link, btRigidBody& body, double max_force_n);

 private:
  DynamicLimb(PhysicsWorld& world, const RobotPlan& plan, std::vector<int> groups);
  Result<void> build(const Pose& world_T_root, const std::vector<double>& positions);
  void set_up_link(int link, const std::vector<PrincipalFrame>& frames);
  Result<void> add_collider(int link, const PrincipalFrame& frame);
  void add_motors();
  void add_gears();
  void own(std::unique_ptr<btMultiBodyConstraint> constraint);
  void update_colliders();

  PhysicsWorld* world_;
  const RobotPlan* plan_;
  std::vector<int> groups_;
  std::unique_ptr<btMultiBody> body_;
  std::vector<Pose> com_T_group_;  // by link
  std::vector<CollisionShape> shapes_;
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders_;
  std::vector<std::unique_ptr<btMultiBodyConstraint>> constraints_;
  std::vector<btMultiBodyJointMotor*> motors_;  // by link
  std::vector<double> efforts_;                 // applied as they are, by link
  btTransform root_end_;
};

}  // namespace extperfc::simulate
