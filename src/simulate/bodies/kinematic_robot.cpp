#include "simulate/bodies/kinematic_robot.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "simulate/bodies/bullet_conversions.hpp"

namespace extperfc::simulate {
namespace {

/// What is held and lags behind the hand by more than this slips in it.
constexpr double kSlip = 0.005;     // [m]
constexpr double kSlipAngle = 0.1;  // [rad]

}  // namespace

KinematicRobot::KinematicRobot(PhysicsWorld& world, Scenery& scenery, const RobotPlan& plan,
                               const Pose& world_T_root, std::vector<double> start_positions)
    : RobotBody(plan, std::move(start_positions)),
      world_(&world),
      scenery_(&scenery),
      world_T_root_(world_T_root),
      next_(positions()),
      held_(plan.grippers.size()) {}

Result<std::unique_ptr<RobotBody>> KinematicRobot::make(PhysicsWorld& world, Scenery& scenery,
                                                        const RobotPlan& plan, const Pose& world_T_root,
                                                        std::vector<double> start_positions) {
  std::unique_ptr<KinematicRobot> robot(
      new KinematicRobot(world, scenery, plan, world_T_root, std::move(start_positions)));
  const auto root_T_link = plan.model->link_poses(robot->positions());
  for (std::size_t i = 0; i < plan.tree.groups.size(); ++i) {
    const RigidGroup& group = plan.tree.groups[i];
    robot->links_.emplace_back();
    if (group.joint < 0) continue;
    auto shape = CollisionShape::make("link " + plan.model->links()[group.link].name, group.collisions,
                                      Pose::Identity());
    if (!shape) return tl::unexpected<Error>(shape.error());
    robot->links_.back() = std::make_unique<KinematicBody>(
        world, std::move(*shape), world_T_root * root_T_link[group.link], ObjectKind::kLink,
        static_cast<int>(i), kLinkGroup, group.collisions.empty() ? 0 : kLooseGroup);
  }
  return robot;
}

Pose KinematicRobot::world_T_group(int group) const {
  return from_bullet(links_[group]->bullet().getWorldTransform());
}

double KinematicRobot::next_finger(int gripper) const {
  const GripperFingers& fingers = plan().grippers[gripper];
  const double wanted = target(fingers.joint).position;
  const auto& held = held_[gripper];
  const double now = positions()[fingers.joint];
  const double goal =
      held && fingers.closing * (wanted - held->finger_position) > 0 ? held->finger_position : wanted;
  const double farthest = speed_limit(fingers.joint) * world_->step_s();
  return now + std::clamp(goal - now, -farthest, farthest);
}

std::vector<double> KinematicRobot::next_positions() const {
  std::vector<double> next(positions().size());
  for (std::size_t i = 0; i < next.size(); ++i) next[i] = target(static_cast<int>(i)).position;
  for (std::size_t i = 0; i < held_.size(); ++i)
    next[plan().grippers[i].joint] = next_finger(static_cast<int>(i));
  for (std::size_t i = 0; i < next.size(); ++i)
    next[i] = followed_position(*plan().model, static_cast<int>(i), next);
  return next;
}

void KinematicRobot::before_step(const Pose& world_T_root) {
  next_ = next_positions();
  world_T_root_ = world_T_root;
  const auto root_T_link = plan().model->link_poses(next_);
  for (std::size_t i = 0; i < links_.size(); ++i)
    if (links_[i]) links_[i]->aim(world_T_root * root_T_link[plan().tree.groups[i].link]);
  carry(root_T_link, world_T_root);
}

void KinematicRobot::carry(const std::vector<Pose>& root_T_link, const Pose& world_T_root) {
  for (std::size_t i = 0; i < held_.size(); ++i) {
    if (!held_[i]) continue;
    const Pose world_T_hand = world_T_root * root_T_link[plan().tree.groups[plan().grippers[i].hand].link];
    scenery_->drive(held_[i]->body, world_T_hand * held_[i]->hand_T_body);
  }
}

void KinematicRobot::after_step() {
  for (auto& link : links_)
    if (link) link->arrive();
  for (std::size_t i = 0; i < next_.size(); ++i)
    set_state(static_cast<int>(i), next_[i], (next_[i] - positions()[i]) / world_->step_s());
  for (std::size_t i = 0; i < held_.size(); ++i) {
    if (!held_[i]) continue;
    const Pose world_T_hand = world_T_group(plan().grippers[i].hand);
    const Pose now = world_T_hand.inverse() * scenery_->world_T_body(held_[i]->body);
    const Pose error = held_[i]->hand_T_body.inverse() * now;
    if (error.translation().norm() > kSlip || Eigen::AngleAxisd(error.linear()).angle() > kSlipAngle)
      held_[i]->hand_T_body = now;
  }
}

void KinematicRobot::jump(const Pose& world_T_root) {
  const Pose moved = world_T_root * world_T_root_.inverse();
  world_T_root_ = world_T_root;
  const auto root_T_link = plan().model->link_poses(positions());
  for (std::size_t i = 0; i < links_.size(); ++i) {
    if (!links_[i]) continue;
    links_[i]->place(world_T_root * root_T_link[plan().tree.groups[i].link]);
  }
  for (const auto& held : held_)
    if (held) scenery_->place(held->body, moved * scenery_->world_T_body(held->body));
}

void KinematicRobot::set_contacts(int gripper, int body, bool on) {
  const GripperFingers& fingers = plan().grippers[gripper];
  for (const int group : {fingers.hand, fingers.finger, fingers.mimic_finger})
    world_->set_contacts(links_[group]->bullet(), scenery_->bullet(body), on);
}

double KinematicRobot::hold(int gripper, int body, double overlap_m) {
  const GripperFingers& fingers = plan().grippers[gripper];
  Held held;
  held.body = body;
  // The overlap was found where the step began.
  const double travel = fingers.closing * velocities()[fingers.joint] * world_->step_s();
  held.finger_position = positions()[fingers.joint] - fingers.closing * std::max(0.0, overlap_m + travel);
  held.hand_T_body = world_T_group(fingers.hand).inverse() * scenery_->world_T_body(body);
  held_[gripper] = held;
  set_contacts(gripper, body, false);
  return held.finger_position;
}

void KinematicRobot::release(int gripper) {
  if (!held_[gripper]) return;
  set_contacts(gripper, held_[gripper]->body, true);
  held_[gripper].reset();
}

}  // namespace extperfc::simulate
