#include "simulate/bodies/kinematic_body.hpp"

#include <utility>

#include "simulate/bodies/bullet_conversions.hpp"

namespace extperfc::simulate {

KinematicBody::KinematicBody(PhysicsWorld& world, CollisionShape shape, const Pose& world_T_body,
                             ObjectKind kind, int number, int group, int mask)
    : world_(&world), shape_(std::move(shape)), end_(to_bullet(world_T_body)) {
  btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shape_.get());
  info.m_startWorldTransform = end_;
  info.m_friction = 1.0;
  body_ = std::make_unique<btRigidBody>(info);
  body_->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
  body_->setActivationState(DISABLE_DEACTIVATION);
  body_->setUserIndex(static_cast<int>(kind));
  body_->setUserIndex2(number);
  world_->bullet().addRigidBody(body_.get(), group, mask);
}

KinematicBody::~KinematicBody() {
  world_->bullet().removeRigidBody(body_.get());
}

void KinematicBody::aim(const Pose& world_T_body) {
  end_ = to_bullet(world_T_body);
  const btTransform& start = body_->getWorldTransform();
  const btVector3 motion = end_.getOrigin() - start.getOrigin();
  // Bullet takes the velocity of a kinematic body from its previous motion. Contacts are found where the
  // step starts, so its next motion counts: the start is mirrored.
  const btMatrix3x3 rotation = end_.getBasis() * start.getBasis().transpose();
  body_->setInterpolationWorldTransform(
      btTransform(rotation.transpose() * start.getBasis(), start.getOrigin() - motion));
}

void KinematicBody::arrive() {
  body_->setWorldTransform(end_);
  body_->setInterpolationWorldTransform(end_);
}

void KinematicBody::place(const Pose& world_T_body) {
  end_ = to_bullet(world_T_body);
  arrive();
}

}  // namespace extperfc::simulate
