#include "simulate/bodies/dynamic_limb.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <BulletDynamics/Featherstone/btMultiBodyFixedConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyGearConstraint.h>

#include "simulate/bodies/bullet_conversions.hpp"
#include "simulate/bodies/joint_stop.hpp"

namespace extperfc::simulate {
namespace {

/// Fraction of a position error that a motor takes back in one step.
constexpr double kPositionGain = 0.4;
/// Bound of every joint's speed, against blow-ups [rad/s] or [m/s].
constexpr double kLargestSpeed = 20;
/// Of a motor whose joint names none [N m] or [N].
constexpr double kDefaultEffort = 1000;
/// Pads of the fingers are rubber.
constexpr double kFingerFriction = 1.5;
constexpr double kLinkFriction = 0.6;
constexpr double kGearForce = 500;  // [N]

double effort_limit(const Joint& joint, const JointTarget& target) {
  const double own = joint.max_effort > 0 ? joint.max_effort : kDefaultEffort;
  return target.max_effort > 0 ? std::min(target.max_effort, own) : own;
}

bool is_finger(const RobotPlan& plan, int group) {
  return std::any_of(plan.grippers.begin(), plan.grippers.end(), [group](const GripperFingers& gripper) {
    return gripper.finger == group || gripper.mimic_finger == group;
  });
}

/// A link without mass would make the equations singular.
PrincipalFrame principal_frame_of(const RigidGroup& group) {
  PrincipalFrame frame = principal_frame(group.mass);
  frame.moments_kg_m2 = frame.moments_kg_m2.cwiseMax(1e-5);
  return frame;
}

}  // namespace

DynamicLimb::DynamicLimb(PhysicsWorld& world, const RobotPlan& plan, std::vector<int> groups)
    : world_(&world),
      plan_(&plan),
      groups_(std::move(groups)),
      body_(std::make_unique<btMultiBody>(links(), 1.0, btVector3(1, 1, 1), true, false)),
      efforts_(groups_.size(), 0.0),
      root_end_(btTransform::getIdentity()) {}

Result<std::unique_ptr<DynamicLimb>> DynamicLimb::make(PhysicsWorld& world, const RobotPlan& plan,
                                                       std::vector<int> groups, const Pose& world_T_root,
                                                       const std::vector<double>& positions) {
  std::unique_ptr<DynamicLimb> limb(new DynamicLimb(world, plan, std::move(groups)));
  if (auto built = limb->build(world_T_root, positions); !built) return tl::unexpected<Error>(built.error());
  return limb;
}

DynamicLimb::~DynamicLimb() {
  for (auto& constraint : constraints_) world_->bullet().removeMultiBodyConstraint(constraint.get());
  for (auto& collider : colliders_) world_->bullet().removeCollisionObject(collider.get());
  world_->bullet().removeMultiBody(body_.get());
}

Result<void> DynamicLimb::build(const Pose& world_T_root, const std::vector<double>& positions) {
  std::vector<PrincipalFrame> frames;
  frames.reserve(groups_.size());
  for (const int group : groups_) frames.push_back(principal_frame_of(plan_->tree.groups[group]));
  for (int i = 0; i < links(); ++i) set_up_link(i, frames);
  body_->finalizeMultiDof();
  body_->setHasSelfCollision(false);
  body_->setLinearDamping(0);
  body_->setAngularDamping(0);
  body_->setMaxCoordinateVelocity(kLargestSpeed);
  for (int i = 0; i < links(); ++i) body_->setJointPos(i, positions[plan_->tree.groups[groups_[i]].joint]);
  world_->bullet().addMultiBody(body_.get());
  for (int i = 0; i < links(); ++i)
    if (auto added = add_collider(i, frames[i]); !added) return added;
  place_root(world_T_root);
  add_motors();
  add_gears();
  return {};
}

void DynamicLimb::set_up_link(int link, const std::vector<PrincipalFrame>& frames) {
  const RigidGroup& group = plan_->tree.groups[groups_[link]];
  const Joint& joint = plan_->model->joints()[group.joint];
  const int parent = group.parent == 0 ? -1 : link_of(group.parent);
  const Pose parent_com_T_joint =
      (parent < 0 ? Pose::Identity() : frames[parent].frame_T_principal.inverse()) * group.parent_T_joint;
  const Pose com_T_joint = frames[link].frame_T_principal.inverse();
  const Eigen::Quaterniond rotation(com_T_joint.linear() * parent_com_T_joint.linear().transpose());
  const btQuaternion parent_to_this(rotation.x(), rotation.y(), rotation.z(), rotation.w());
  const btVector3 axis = to_bullet(Eigen::Vector3d(com_T_joint.linear() * joint.axis));
  const btVector3 to_pivot = to_bullet(Eigen::Vector3d(parent_com_T_joint.translation()));
  const btVector3 to_com = to_bullet(Eigen::Vector3d(-com_T_joint.translation()));
  const double mass = std::max(group.mass.mass_kg, 0.01);
  const btVector3 moments = to_bullet(frames[link].moments_kg_m2);
  if (joint.type == JointType::kPrismatic)
    body_->setupPrismatic(link, mass, moments, parent, parent_to_this, axis, to_pivot, to_com, true);
  else
    body_->setupRevolute(link, mass, moments, parent, parent_to_this, axis, to_pivot, to_com, true);
}

Result<void> DynamicLimb::add_collider(int link, const PrincipalFrame& frame) {
  const RigidGroup& group = plan_->tree.groups[groups_[link]];
  auto shape = CollisionShape::make("link " + plan_->model->links()[group.link].name, group.collisions,
                                    frame.frame_T_principal.inverse());
  if (!shape) return tl::unexpected<Error>(shape.error());
  shapes_.push_back(std::move(*shape));
  com_T_group_.push_back(frame.frame_T_principal.inverse());
  auto collider = std::make_unique<btMultiBodyLinkCollider>(body_.get(), link);
  collider->setCollisionShape(shapes_.back().get());
  const bool finger = is_finger(*plan_, groups_[link]);
  collider->setFriction(finger ? kFingerFriction : kLinkFriction);
  collider->setUserIndex(static_cast<int>(ObjectKind::kLink));
  collider->setUserIndex2(groups_[link]);
  world_->bullet().addCollisionObject(
      collider.get(), kLinkGroup, group.collisions.empty() ? 0 : kStaticGroup | kLooseGroup | kPersonGroup);
  body_->getLink(link).m_collider = collider.get();
  colliders_.push_back(std::move(collider));
  return {};
}

void DynamicLimb::own(std::unique_ptr<btMultiBodyConstraint> constraint) {
  constraint->finalizeMultiDof();
  world_->bullet().addMultiBodyConstraint(constraint.get());
  constraints_.push_back(std::move(constraint));
}

void DynamicLimb::add_motors() {
  for (int i = 0; i < links(); ++i) {
    const Joint& joint = plan_->model->joints()[plan_->tree.groups[groups_[i]].joint];
    auto motor = std::make_unique<btMultiBodyJointMotor>(body_.get(), i, 0.0, 0.0);
    motors_.push_back(motor.get());
    own(std::move(motor));
    own(std::make_unique<JointStop>(*body_, i, joint.lower, joint.upper, kLargestSpeed * world_->step_s()));
  }
}

void DynamicLimb::add_gears() {
  for (int i = 0; i < links(); ++i) {
    const Joint& joint = plan_->model->joints()[plan_->tree.groups[groups_[i]].joint];
    if (!joint.mimic || joint.mimic->multiplier == 0) continue;
    const int driver = link_of(plan_->tree.group_of_joint[joint.mimic->joint]);
    if (driver < 0) continue;
    // q_driver + ratio q_mimic = target.
    auto gear = std::make_unique<btMultiBodyGearConstraint>(
        body_.get(), driver, body_.get(), i, btVector3(0, 0, 0), btVector3(0, 0, 0),
        btMatrix3x3::getIdentity(), btMatrix3x3::getIdentity());
    gear->setGearRatio(-1 / joint.mimic->multiplier);
    gear->setRelativePositionTarget(-joint.mimic->offset / joint.mimic->multiplier);
    gear->setErp(1);
    gear->setMaxAppliedImpulse(kGearForce * world_->step_s());
    own(std::move(gear));
  }
}

int DynamicLimb::link_of(int group) const {
  const auto found = std::find(groups_.begin(), groups_.end(), group);
  return found == groups_.end() ? -1 : static_cast<int>(found - groups_.begin());
}

Pose DynamicLimb::world_T_group(int link) const {
  return from_bullet(colliders_[link]->getWorldTransform()) * com_T_group_[link];
}

void DynamicLimb::drive(int link, const Joint& joint, const JointTarget& target, double speed_limit) {
  btMultiBodyJointMotor& motor = *motors_[link];
  const double limit = effort_limit(joint, target);
  efforts_[link] = 0;
  motor.setRhsClamp(speed_limit);
  motor.setMaxAppliedImpulse(limit * world_->step_s());
  switch (target.drive) {
    case Drive::kPosition:
      // The motor adds the velocity to what the error asks for: the error is the one where the step starts.
      motor.setPositionTarget(target.position - target.velocity * world_->step_s(), kPositionGain);
      motor.setVelocityTarget(target.velocity, 1);
      break;
    case Drive::kVelocity:
      motor.setPositionTarget(0, 0);
      motor.setVelocityTarget(target.velocity, 1);
      break;
    case Drive::kEffort:
      motor.setMaxAppliedImpulse(0);
      efforts_[link] = std::clamp(target.effort, -limit, limit);
      body_->addJointTorque(link, efforts_[link]);
      break;
  }
}

void DynamicLimb::push(int link, const btVector3& force_n, const btVector3& world_point) {
  const btVector3 arm = world_point - colliders_[link]->getWorldTransform().getOrigin();
  body_->addLinkForce(link, force_n);
  body_->addLinkTorque(link, arm.cross(force_n));
}

void DynamicLimb::aim_root(const Pose& world_T_root) {
  root_end_ = to_bullet(world_T_root);
  btVector3 linear;
  btVector3 angular;
  btTransformUtil::calculateVelocity(body_->getBaseWorldTransform(), root_end_, world_->step_s(), linear,
                                     angular);
  body_->setBaseVel(linear);
  body_->setBaseOmega(angular);
}

void DynamicLimb::update_colliders() {
  btAlignedObjectArray<btQuaternion> rotations;
  btAlignedObjectArray<btVector3> origins;
  body_->forwardKinematics(rotations, origins);
  body_->updateCollisionObjectWorldTransforms(rotations, origins);
}

void DynamicLimb::arrive_root() {
  body_->setBaseWorldTransform(root_end_);
  update_colliders();
  for (int i = 0; i < links(); ++i)
    if (motors_[i]->getMaxAppliedImpulse() > 0)
      efforts_[i] = motors_[i]->getAppliedImpulse(0) / world_->step_s();
}

void DynamicLimb::place_root(const Pose& world_T_root) {
  root_end_ = to_bullet(world_T_root);
  body_->setBaseWorldTransform(root_end_);
  body_->setBaseVel({0, 0, 0});
  body_->setBaseOmega({0, 0, 0});
  update_colliders();
}

std::unique_ptr<btMultiBodyConstraint> DynamicLimb::weld(int link, btRigidBody& body, double max_force_n) {
  const btTransform link_T_body = colliders_[link]->getWorldTransform().inverse() * body.getWorldTransform();
  auto weld = std::make_unique<btMultiBodyFixedConstraint>(body_.get(), link, &body, link_T_body.getOrigin(),
                                                           btVector3(0, 0, 0), link_T_body.getBasis(),
                                                           btMatrix3x3::getIdentity());
  weld->setMaxAppliedImpulse(max_force_n * world_->step_s());
  weld->finalizeMultiDof();
  return weld;
}

}  // namespace extperfc::simulate
