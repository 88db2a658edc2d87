#include "simulate/bodies/grips.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "simulate/bodies/bullet_conversions.hpp"

namespace extperfc::simulate {
namespace {

constexpr double kTouchDistance = 0.0003;  // [m]
/// A contact may miss for some steps while the fingers press on.
constexpr double kForgetS = 0.05;
/// In dynamic mode the fingers press for this long before a held body becomes fixed in the hand.
constexpr double kSettleS = 0.08;
/// A held body that is farther from its place in the hand than this was lost [m].
constexpr double kLost = 0.03;
/// Fraction of a contact's normal that must point along the finger's motion.
constexpr double kFacing = 0.7;

}  // namespace

Grips::Grips(const BodiesParams& params, const RobotPlan& plan, PhysicsWorld& world, Scenery& scenery,
             RobotBody& robot)
    : params_(params),
      plan_(&plan),
      world_(&world),
      scenery_(&scenery),
      robot_(&robot),
      grips_(plan.grippers.size()) {}

Eigen::Vector3d Grips::closing_direction(int gripper, int side) const {
  const GripperFingers& fingers = plan_->grippers[gripper];
  const RigidGroup& group = plan_->tree.groups[fingers.finger];
  const Eigen::Vector3d axis = plan_->model->joints()[group.joint].axis;
  const Eigen::Vector3d closing =
      fingers.closing * (robot_->world_T_group(fingers.hand) * group.parent_T_joint).linear() * axis;
  return side == 0 ? closing : Eigen::Vector3d(-closing);
}

void Grips::add_touch(const Touch& touch) {
  for (Touch& known : touches_) {
    if (known.gripper != touch.gripper || known.side != touch.side || known.body != touch.body) continue;
    known.distance = std::min(known.distance, touch.distance);
    known.impulse += touch.impulse;
    return;
  }
  touches_.push_back(touch);
}

void Grips::add_touches(const btPersistentManifold& manifold) {
  const btCollisionObject* const a = manifold.getBody0();
  const btCollisionObject* const b = manifold.getBody1();
  const bool a_is_link = a->getUserIndex() == static_cast<int>(ObjectKind::kLink);
  const btCollisionObject* const link = a_is_link ? a : b;
  const btCollisionObject* const other = a_is_link ? b : a;
  if (link->getUserIndex() != static_cast<int>(ObjectKind::kLink) ||
      other->getUserIndex() != static_cast<int>(ObjectKind::kBody) ||
      !scenery_->is_loose(other->getUserIndex2()))
    return;
  for (std::size_t g = 0; g < grips_.size(); ++g) {
    const GripperFingers& fingers = plan_->grippers[g];
    const int group = link->getUserIndex2();
    if (group != fingers.finger && group != fingers.mimic_finger) continue;
    const int side = group == fingers.finger ? 0 : 1;
    const Eigen::Vector3d inward = closing_direction(static_cast<int>(g), side);
    for (int i = 0; i < manifold.getNumContacts(); ++i) {
      const btManifoldPoint& point = manifold.getContactPoint(i);
      // Bullet's normal points from the second object to the first one.
      const Eigen::Vector3d to_body = (a_is_link ? -1 : 1) * from_bullet(point.m_normalWorldOnB);
      if (point.getDistance() > kTouchDistance || to_body.dot(inward) < kFacing) continue;
      add_touch({static_cast<int>(g), side, other->getUserIndex2(), point.getDistance(),
                 point.getAppliedImpulse()});
    }
  }
}

void Grips::find_touches() {
  touches_.clear();
  const btDispatcher& dispatcher = *world_->bullet().getDispatcher();
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
    add_touches(*const_cast<btDispatcher&>(dispatcher).getManifoldByIndexInternal(i));
}

std::optional<Grips::Touch> Grips::between_fingers(int gripper) const {
  for (const Touch& first : touches_)
    for (const Touch& second : touches_) {
      if (first.gripper != gripper || second.gripper != gripper || first.body != second.body) continue;
      if (first.side != 0 || second.side != 1) continue;
      return Touch{gripper, 0, first.body, 0.5 * (first.distance + second.distance),
                   0.5 * (first.impulse + second.impulse)};
    }
  return std::nullopt;
}

void Grips::update_touched(int gripper) {
  Grip& grip = grips_[gripper];
  if (grip.held) return;  // its contacts are off
  if (const auto between = between_fingers(gripper)) {
    grip.steps_touched = grip.touched == between->body ? grip.steps_touched + 1 : 1;
    grip.steps_apart = 0;
    grip.touched = between->body;
    grip.overlap_m = -between->distance;
    grip.force_n = between->impulse / world_->step_s();
  } else if (++grip.steps_apart * world_->step_s() > kForgetS) {
    grip = Grip{};
  }
}

bool Grips::shall_go(double direction, int gripper, double from_m, double by_m) const {
  const GripperFingers& fingers = plan_->grippers[gripper];
  const JointTarget& target = robot_->target(fingers.joint);
  const double closing = fingers.closing * direction;
  switch (params_.dynamic ? target.drive : Drive::kPosition) {
    case Drive::kVelocity:
      return closing * target.velocity > 0;
    case Drive::kEffort:
      return closing * target.effort > 0;
    case Drive::kPosition:
      break;
  }
  return closing * (target.position - from_m) > by_m;
}

bool Grips::closes(int gripper) const {
  const GripperFingers& fingers = plan_->grippers[gripper];
  constexpr double kCloses = 1e-4;  // [m]
  // Without motors a finger is at its set point: the distance that it moved counts, too.
  const bool came_closing = !params_.dynamic && fingers.closing * robot_->velocities()[fingers.joint] > 0;
  return came_closing || shall_go(1, gripper, robot_->positions()[fingers.joint], kCloses);
}

bool Grips::opens(int gripper) const {
  constexpr double kOpens = 5e-4;  // [m]
  const GripperFingers& fingers = plan_->grippers[gripper];
  const auto& joint = plan_->model->joints()[fingers.joint];
  // Fingers that hold something about as wide as they open cannot open by more than the rest.
  const double held = grips_[gripper].finger_position;
  const double from = fingers.closing > 0 ? std::max(held, joint.lower + 2 * kOpens)
                                          : std::min(held, joint.upper - 2 * kOpens);
  return shall_go(-1, gripper, from, kOpens);
}

Pose Grips::hand_T_body(int gripper, int body) const {
  return robot_->world_T_group(plan_->grippers[gripper].hand).inverse() * scenery_->world_T_body(body);
}

void Grips::update_held(int gripper) {
  Grip& grip = grips_[gripper];
  if (grip.held) {
    const double moved_m =
        (hand_T_body(gripper, *grip.touched).translation() - grip.hand_T_body.translation()).norm();
    if (opens(gripper) || moved_m > kLost) {
      robot_->release(gripper);
      grip = Grip{};
    }
    return;
  }
  const bool settled = !params_.dynamic || grip.steps_touched * world_->step_s() >= kSettleS;
  if (!grip.touched || !settled || !closes(gripper)) return;
  if (params_.dynamic && !params_.hold_gripped) return;
  grip.held = true;
  grip.hand_T_body = hand_T_body(gripper, *grip.touched);
  grip.finger_position = robot_->hold(gripper, *grip.touched, grip.overlap_m);
}

void Grips::update() {
  find_touches();
  for (int i = 0; i < static_cast<int>(grips_.size()); ++i) {
    update_touched(i);
    update_held(i);
  }
}

void Grips::let_go_of(int body) {
  for (int i = 0; i < static_cast<int>(grips_.size()); ++i) {
    if (grips_[i].touched != body) continue;
    robot_->release(i);
    grips_[i] = Grip{};
  }
}

int Grips::gripper_of(int finger_joint) const {
  for (std::size_t i = 0; i < grips_.size(); ++i)
    if (plan_->grippers[i].joint == finger_joint) return static_cast<int>(i);
  return -1;
}

std::optional<int> Grips::gripped(int finger_joint) const {
  const int gripper = gripper_of(finger_joint);
  return gripper < 0 ? std::nullopt : grips_[gripper].touched;
}

double Grips::force(int finger_joint) const {
  const int gripper = gripper_of(finger_joint);
  if (gripper < 0) return 0;
  const Grip& grip = grips_[gripper];
  if (!grip.held) return params_.dynamic ? grip.force_n : 0;
  // What is held has no contacts any more: the motor presses as hard as it may.
  if (!shall_go(1, gripper, grip.finger_position, 0)) return 0;
  const double own = plan_->model->joints()[finger_joint].max_effort;
  const double wanted = robot_->target(finger_joint).max_effort;
  return wanted > 0 ? std::min(wanted, own) : own;
}

}  // namespace extperfc::simulate
