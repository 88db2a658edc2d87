#include "simulate/bodies/dynamic_robot.hpp"

#include <cstddef>
#include <utility>

namespace extperfc::simulate {
namespace {

/// What pulls harder on a held object takes it out of the hand [N].
constexpr double kHoldForce = 60;

/// Groups of each tree on the root, parents first.
std::vector<std::vector<int>> limbs_of(const RigidTree& tree) {
  std::vector<std::vector<int>> limbs;
  std::vector<int> limb_of(tree.groups.size(), -1);
  for (std::size_t i = 1; i < tree.groups.size(); ++i) {
    const int parent = tree.groups[i].parent;
    if (parent == 0) {
      limb_of[i] = static_cast<int>(limbs.size());
      limbs.emplace_back();
    } else {
      limb_of[i] = limb_of[parent];
    }
    limbs[limb_of[i]].push_back(static_cast<int>(i));
  }
  return limbs;
}

}  // namespace

DynamicRobot::DynamicRobot(PhysicsWorld& world, Scenery& scenery, const RobotPlan& plan,
                           const Pose& world_T_root, std::vector<double> start_positions)
    : RobotBody(plan, std::move(start_positions)),
      world_(&world),
      scenery_(&scenery),
      world_T_root_(world_T_root),
      places_(plan.tree.groups.size()),
      held_(plan.grippers.size()) {}

Result<std::unique_ptr<RobotBody>> DynamicRobot::make(PhysicsWorld& world, Scenery& scenery,
                                                      const RobotPlan& plan, const Pose& world_T_root,
                                                      std::vector<double> start_positions) {
  std::unique_ptr<DynamicRobot> robot(
      new DynamicRobot(world, scenery, plan, world_T_root, std::move(start_positions)));
  for (auto& groups : limbs_of(plan.tree)) {
    auto limb = DynamicLimb::make(world, plan, std::move(groups), world_T_root, robot->positions());
    if (!limb) return tl::unexpected<Error>(limb.error());
    for (int link = 0; link < (*limb)->links(); ++link)
      robot->places_[(*limb)->group(link)] = {static_cast<int>(robot->limbs_.size()), link};
    robot->limbs_.push_back(std::move(*limb));
  }
  return robot;
}

DynamicRobot::~DynamicRobot() {
  for (std::size_t i = 0; i < held_.size(); ++i) DynamicRobot::release(static_cast<int>(i));
}

JointTarget DynamicRobot::target_with_mimic(int joint) const {
  const auto& mimic = plan().model->joints()[joint].mimic;
  if (!mimic) return target(joint);
  JointTarget followed = target(mimic->joint);
  followed.position = mimic->multiplier * followed.position + mimic->offset;
  followed.velocity *= mimic->multiplier;
  followed.effort *= mimic->multiplier;
  return followed;
}

JointTarget DynamicRobot::target_with_grip(int joint) const {
  for (std::size_t i = 0; i < held_.size(); ++i) {
    const GripperFingers& fingers = plan().grippers[i];
    if (!held_[i].weld || (joint != fingers.joint && joint != fingers.mimic_joint)) continue;
    auto positions = this->positions();
    positions[fingers.joint] = held_[i].finger_position;
    return {Drive::kPosition, followed_position(*plan().model, joint, positions), 0, 0, 0};
  }
  return target_with_mimic(joint);
}

void DynamicRobot::before_step(const Pose& world_T_root) {
  world_T_root_ = world_T_root;
  for (auto& limb : limbs_) {
    limb->aim_root(world_T_root);
    for (int link = 0; link < limb->links(); ++link) {
      const int joint = plan().tree.groups[limb->group(link)].joint;
      limb->drive(link, plan().model->joints()[joint], target_with_grip(joint), speed_limit(joint));
    }
  }
  carry_loads();
}

void DynamicRobot::carry_loads() {
  for (std::size_t i = 0; i < held_.size(); ++i) {
    if (!held_[i].weld) continue;
    const Place& hand = places_[plan().grippers[i].hand];
    const btRigidBody& body = scenery_->bullet(held_[i].body);
    limbs_[hand.limb]->push(hand.link, world_->bullet().getGravity() / body.getInvMass(),
                            body.getWorldTransform().getOrigin());
  }
}

void DynamicRobot::move_free_joints() {
  const auto& joints = plan().model->joints();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (plan().tree.group_of_joint[i] >= 0) continue;
    const int joint = static_cast<int>(i);
    const JointTarget& wanted = target(joint);
    const double now = positions()[i];
    const double next =
        wanted.drive == Drive::kVelocity ? now + wanted.velocity * world_->step_s() : wanted.position;
    set_state(joint, next, (next - now) / world_->step_s());
  }
}

void DynamicRobot::after_step() {
  for (auto& limb : limbs_) {
    limb->arrive_root();
    for (int link = 0; link < limb->links(); ++link)
      set_state(plan().tree.groups[limb->group(link)].joint, limb->position(link), limb->velocity(link));
  }
  move_free_joints();
}

void DynamicRobot::jump(const Pose& world_T_root) {
  const Pose moved = world_T_root * world_T_root_.inverse();
  world_T_root_ = world_T_root;
  for (auto& limb : limbs_) limb->place_root(world_T_root);
  for (const Held& held : held_)
    if (held.weld) scenery_->place(held.body, moved * scenery_->world_T_body(held.body));
}

double DynamicRobot::motor_effort(int joint) const {
  const int group = plan().tree.group_of_joint[joint];
  return group < 0 ? 0 : limbs_[places_[group].limb]->effort(places_[group].link);
}

Pose DynamicRobot::world_T_group(int group) const {
  return limbs_[places_[group].limb]->world_T_group(places_[group].link);
}

void DynamicRobot::set_contacts(int gripper, int body, bool on) {
  const GripperFingers& fingers = plan().grippers[gripper];
  for (const int group : {fingers.hand, fingers.finger, fingers.mimic_finger})
    world_->set_contacts(limbs_[places_[group].limb]->object(places_[group].link), scenery_->bullet(body),
                         on);
}

double DynamicRobot::hold(int gripper, int body, double /*overlap_m*/) {
  const GripperFingers& fingers = plan().grippers[gripper];
  const Place& hand = places_[fingers.hand];
  Held& held = held_[gripper];
  held.body = body;
  held.finger_position = positions()[fingers.joint];
  held.weld = limbs_[hand.limb]->weld(hand.link, scenery_->bullet(body), kHoldForce);
  world_->bullet().addMultiBodyConstraint(held.weld.get());
  // Bullet's multibody constraints see the weight of a rigid body a step late, which lets it sag: the hand
  // takes it at once instead.
  scenery_->bullet(body).setGravity({0, 0, 0});
  // Pads that press against a body which cannot yield would only shake it.
  set_contacts(gripper, body, false);
  return held.finger_position;
}

void DynamicRobot::release(int gripper) {
  Held& held = held_[gripper];
  if (!held.weld) return;
  world_->bullet().removeMultiBodyConstraint(held.weld.get());
  held.weld.reset();
  scenery_->bullet(held.body).setGravity(world_->bullet().getGravity());
  set_contacts(gripper, held.body, true);
}

}  // namespace extperfc::simulate
