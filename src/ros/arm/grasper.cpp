#include "ros/arm/grasper.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <optional>
#include <utility>

#include "extperfc/arm/cartesian_path.hpp"

#include "ros/arm/grasper_common.hpp"
#include "ros/arm/support.hpp"
#include "ros/convert/geometry.hpp"

namespace extperfc::arm_node {

using arm::ArmCode;
using arm::JointPositions;
using arm::JointVector;
using extperfc::SceneObject;

namespace {

constexpr double kMinLift = 0.75;  ///< fraction of the wanted lift that is still accepted
constexpr std::size_t kMaxPlaces = 10;

/// Cancelled by a caller or stopped by the robot: the grasper must not move the arm any more.
bool ended_from_outside(const Status& status) {
  return status.code == ArmCode::kCancelled || status.code == ArmCode::kPreempted ||
         status.code == ArmCode::kRobotStopped || status.code == ArmCode::kRobotNotEnabled;
}

}  // namespace

Result<std::unique_ptr<Grasper>> Grasper::make(const ros::NodeHandle& handle, PlanExecution& execution) {
  const auto& shared = execution.shared();
  std::vector<Hand> hands;
  for (const auto& names : shared.params.grippers) {
    const auto wrong = [&](const Error& error) {
      return fail(error.code, "gripper " + names.name + ": " + error.message);
    };
    if (auto group = shared.arms.group(names.group); !group) return wrong(group.error());
    auto shape = arm::hand_of(shared.arms.robot(), names.tip, names.finger_joint);
    if (!shape) return wrong(shape.error());
    auto chain = arm::ArmChain::make(shared.arms.robot(), shared.arms.root_link(), names.tip);
    if (!chain) return wrong(chain.error());
    const auto& grasp = shared.params.grasp;
    hands.push_back(
        {names,
         std::move(*shape),
         arm::InverseKinematics(std::move(*chain)),
         std::make_unique<Gripper>(handle, names.action,
                                   Gripper::Params{grasp.effort_percent, grasp.gripper_timeout_s}),
         {}});
  }
  return std::unique_ptr<Grasper>(new Grasper(execution, std::move(hands)));
}

// Pick.

Grasper::Maybe<std::vector<Grasper::Hand*>> Grasper::free_hands(const std::string& arm) {
  std::vector<Hand*> found;
  bool known = false;
  for (auto& hand : hands_) {
    if (!arm.empty() && hand.names.name != arm) continue;
    known = true;
    if (!execution_.shared().scene.held_by(hand.names.tip)) found.push_back(&hand);
  }
  if (!known) return failure(ArmCode::kInvalidRequest, "unknown gripper '" + arm + "'");
  if (found.empty())
    return failure(
        ArmCode::kGrippersFull,
        (arm.empty() ? "all grippers hold" : "the " + arm + " gripper holds") + std::string(" an object"));
  return found;
}

Grasper::Maybe<Grasper::Choice> Grasper::choose(const extperfc::PickGoal& goal,
                                                const MotionCallbacks& callbacks) {
  if (goal.object.empty()) return failure(ArmCode::kInvalidRequest, "the goal names no object");
  const auto hands = free_hands(goal.arm);
  if (!hands) return tl::unexpected(hands.error());
  const auto requirement = requirement_of(goal);
  if (!requirement) return tl::unexpected(requirement.error());
  auto items = execution_.shared().scene.find(goal.object);
  if (!items) return tl::unexpected(items.error());
  items->erase(
      std::remove_if(items->begin(), items->end(), [](const CollisionObject& item) { return item.held; }),
      items->end());
  if (items->empty()) return failure(ArmCode::kUnknownObject, "'" + goal.object + "' is already held");
  std::stable_sort(items->begin(), items->end(), [](const CollisionObject& a, const CollisionObject& b) {
    return a.frame_T_object.translation().head<2>().norm() < b.frame_T_object.translation().head<2>().norm();
  });
  const auto& wanted = execution_.shared().params.grasp.grasp;
  const double lift_m = or_else(goal.lift, wanted.lift_m);
  // First with full clearances, then with smaller ones and more approach directions.
  const std::array<Clearances, 2> clearances_to_try{
      Clearances{wanted.approach_m, lift_m, wanted.tilt_step_rad, true},
      Clearances{std::max(0.02, kMinApproach * wanted.approach_m), kMinLift * lift_m,
                 std::max(0.05, 0.5 * wanted.tilt_step_rad), false}};
  Status last;
  int tried = 0;
  for (const auto& clearances : clearances_to_try)
    for (const auto& item : *items) {
      auto choice = choose(item, *hands, clearances, *requirement, callbacks);
      if (choice) return choice->tried += tried, choice;
      last = choice.error();
      if (last.code != ArmCode::kNoGrasp) return tl::unexpected(last);
    }
  return tl::unexpected(last);
}

Grasper::Maybe<Grasper::Choice> Grasper::choose(const CollisionObject& item, const std::vector<Hand*>& hands,
                                                const Clearances& clearances,
                                                const PlaceRequirement& requirement,
                                                const MotionCallbacks& callbacks) {
  const auto& shared = execution_.shared();
  if (item.shapes.size() != 1)
    return failure(ArmCode::kNoGrasp, item.name + " has " + std::to_string(item.shapes.size()) +
                                          " shapes: only objects of one shape can be grasped");
  std::deque<ReachableGrasps> reachable;  // a deque keeps references valid
  std::string why;
  for (Hand* hand : hands) {
    auto grasps = reachable_grasps(*hand, item, clearances);
    if (grasps)
      reachable.push_back(std::move(*grasps));
    else if (grasps.error().code != ArmCode::kNoGrasp)
      return tl::unexpected(grasps.error());
    else
      why += (why.empty() ? "" : "; ") + hand->names.name + ": " + grasps.error().message;
  }
  if (reachable.empty()) return failure(ArmCode::kNoGrasp, item.name + ": " + why);
  std::vector<arm::GraspArm> arms;
  arms.reserve(reachable.size());
  for (auto& one : reachable)
    arms.push_back({one.hand->names.name, &one.hand->kinematics, &one.checker, one.state, &one.grasps,
                    motions_to_place(item, one, clearances.lift_m, requirement, callbacks)});
  arm::GraspChoiceOptions options;
  options.timeout_s = shared.params.planning_time_s;
  options.cancelled = [&callbacks] { return callbacks.cancel.cancelled(); };
  const auto chosen = arm::choose_grasp({}, arms, options);
  if (const auto reason = callbacks.cancel.reason()) return tl::unexpected(*reason);
  if (!chosen)
    return failure(ArmCode::kNoGrasp,
                   item.name + ": " + chosen.error().message +
                       (requirement.root_T_places.empty() ? "" : "; place_at restricts the grasps"));
  const ReachableGrasps& best = reachable[static_cast<std::size_t>(chosen->arm)];
  Choice choice;
  choice.hand = best.hand;
  choice.item = item;
  choice.grasp = best.grasps[static_cast<std::size_t>(chosen->candidate)];
  choice.tried = chosen->tried;
  choice.approach = chosen->path;
  choice.lift = path_from(best.lifts, chosen->path.back());
  choice.put_down = best.put_down;
  choice.pregrasp = by_name(best.hand->kinematics.chain(), chosen->pregrasp);
  return choice;
}

Grasper::Maybe<Grasper::ReachableGrasps> Grasper::reachable_grasps(Hand& hand, const CollisionObject& item,
                                                                   const Clearances& clearances) {
  const auto& shared = execution_.shared();
  arm::GraspObject object;
  object.geometry = item.shapes.front().geometry;
  object.root_T_object = item.frame_T_object * item.shapes.front().body_T_shape;
  object.support_z_m = heights(object.geometry, object.root_T_object).first;
  auto params = shared.params.grasp.grasp;
  params.approach_m = clearances.approach_m;
  params.tilt_step_rad = clearances.tilt_step_rad;
  params.max_candidates = 400;
  auto grasps = arm::generate_grasps(hand.shape, object, params);
  if (!grasps) return failure(ArmCode::kNoGrasp, grasps.error().message);
  auto open = shared.robot_state.positions();
  if (!open) return tl::unexpected(open.error());
  const auto finger = shared.arms.robot().joint(hand.names.finger_joint);
  (*open)[hand.names.finger_joint] = shared.arms.robot().joints()[static_cast<std::size_t>(*finger)].upper;
  auto world = shared.scene.world();
  if (!world) return tl::unexpected(world.error());
  arm::allow_grasp(*world, item.name, hand.shape);
  auto checker = execution_.pipeline().checker(hand.names.group, *open, *world, clearances.padded);
  if (!checker) return failure(ArmCode::kInternal, checker.error().message);
  const auto state = arm::RobotArms::select(**shared.arms.group(hand.names.group), *open);
  if (!state) return failure(ArmCode::kNoJointStates, state.error().message);
  return ReachableGrasps{&hand, std::move(*grasps), std::move(*checker), *state, {}, {}};
}

arm::StraightMotion Grasper::straight_motions(ReachableGrasps& reachable, double lift_m) const {
  // Planned backwards, from the grasp to the pregrasp.
  return [&reachable, lift_m](const JointVector& grasp,
                              const Pose& root_T_pregrasp) -> std::optional<std::vector<JointVector>> {
    const auto& chain = reachable.hand->kinematics.chain();
    auto planner = arm::CartesianPlanner::make(reachable.checker, chain, quick());
    if (!planner) return std::nullopt;
    auto approach = planner->plan({grasp, {root_T_pregrasp}, {}});
    if (approach.end != arm::CartesianEnd::kComplete) return std::nullopt;
    Pose lifted = chain.forward(grasp);
    lifted.translation().z() += lift_m;
    auto up = planner->plan({grasp, {lifted}, {}});
    if (up.end != arm::CartesianEnd::kComplete) return std::nullopt;
    reachable.lifts.push_back(std::move(up.waypoints));
    return std::move(approach.waypoints);
  };
}

arm::StraightMotion Grasper::motions_to_place(const CollisionObject& item, ReachableGrasps& reachable,
                                              double lift_m, const PlaceRequirement& requirement,
                                              const MotionCallbacks& callbacks) {
  auto motions = straight_motions(reachable, lift_m);
  if (requirement.root_T_places.empty()) return motions;
  // A candidate is tried in several postures; whether the object can be placed does not depend on them.
  std::optional<std::pair<Pose, bool>> last;
  return [this, &item, &reachable, &requirement, &callbacks, motions = std::move(motions), last](
             const JointVector& grasp,
             const Pose& root_T_pregrasp) mutable -> std::optional<std::vector<JointVector>> {
    const bool known = last && last->first.isApprox(root_T_pregrasp, 1e-9);
    if (known && !last->second) return std::nullopt;
    auto path = motions(grasp, root_T_pregrasp);
    if (!path || known) return path;
    const Pose root_T_tip = reachable.hand->kinematics.chain().forward(grasp);
    const auto there = placed(*reachable.hand, item, root_T_tip, requirement, callbacks);
    last.emplace(root_T_pregrasp, there.has_value());
    if (!there) return std::nullopt;
    reachable.put_down = {*there};
    return path;
  };
}

Grasper::Maybe<Grasper::PlaceRequirement> Grasper::requirement_of(const extperfc::PickGoal& goal) const {
  if (goal.place_at.size() > kMaxPlaces)
    return failure(ArmCode::kInvalidRequest, "place_at: at most " + std::to_string(kMaxPlaces) + " poses");
  PlaceRequirement requirement;
  requirement.any_yaw = goal.place_any_yaw != 0;
  for (const auto& place : goal.place_at) {
    const auto root_T_place = execution_.shared().transforms.root_T_pose(place);
    if (!root_T_place) return failure(root_T_place.error().code, "place_at: " + root_T_place.error().message);
    requirement.root_T_places.push_back(*root_T_place);
  }
  return requirement;
}

/// Opens the gripper where it is; the object stays in the scene at that place.
Status Grasper::let_go(Hand& hand, const std::string& name, const Status& why) {
  if (auto opened = hand.gripper->open({}); !opened)
    return {why.code, why.message + "; the gripper does not open: " + opened.error().message};
  if (auto done = change(SceneObject::DETACH, name, nullptr); failed(done))
    return {why.code, why.message + "; " + done.message};
  return {why.code, why.message + "; the gripper released the object"};
}

Status Grasper::pick(const extperfc::PickGoal& goal, const MotionCallbacks& callbacks,
                     extperfc::PickResult& result) {
  const auto& params = execution_.shared().params;
  if (!(goal.lift >= 0.0) || goal.lift > 1.0) return {ArmCode::kInvalidRequest, "lift must be from 0 to 1 m"};
  if (!(goal.planning_time >= 0.0)) return {ArmCode::kInvalidRequest, "planning_time must be 0 s or more"};
  callbacks.progress("choosing", 0.0);
  if (const auto not_ready = execution_.shared().robot_state.not_ready_reason()) return *not_ready;
  // From the choice until the object is grasped, the fingers may hide or push it.
  auto still = execution_.shared().scene.hold(goal.object);
  const auto choice = choose(goal, callbacks);
  if (!choice) return choice.error();
  still = execution_.shared().scene.hold(choice->item.name);
  result.object = choice->item.name;
  result.arm = choice->hand->names.name;
  result.grasps = static_cast<std::uint32_t>(choice->tried);
  return grasp(*choice, or_else(goal.planning_time, params.planning_time_s), callbacks, result);
}

Status Grasper::grasp(const Choice& choice, double time_s, const MotionCallbacks& callbacks,
                      extperfc::PickResult& result) {
  Hand& hand = *choice.hand;
  const std::string& name = choice.item.name;
  hand.put_down = choice.put_down;
  if (auto opened = hand.gripper->open(callbacks); !opened) return opened.error();
  if (auto moved = move_joints(hand, choice.pregrasp, time_s, with_stage(callbacks, "approaching", {}));
      failed(moved))
    return moved;
  const auto touch = [&](arm::CollisionWorld& world) { arm::allow_grasp(world, name, hand.shape); };
  if (auto moved = move_along(hand, choice.approach, time_s, with_stage(callbacks, "approaching", touch));
      failed(moved))
    return moved;
  callbacks.progress("grasping", 0.0);
  const auto tip = tip_now(hand);
  if (!tip) return tip.error();
  result.grasp.header.frame_id = execution_.shared().arms.root_link();
  result.grasp.header.stamp = ros::Time::now();
  result.grasp.pose = convert::to_message(*tip);
  const auto holds = hand.gripper->close(callbacks);
  if (!holds) return holds.error();
  if (!*holds) {
    (void)hand.gripper->open(callbacks);
    return {ArmCode::kGraspMissed, "the gripper closed without holding " + name};
  }
  if (auto done = change(SceneObject::ATTACH, name, &hand); failed(done)) return done;
  const double bottom = heights(choice.item.shapes, choice.item.frame_T_object).first;
  const auto rise = [&](arm::CollisionWorld& world) { allow_support(world, name, bottom); };
  if (auto moved = move_along(hand, choice.lift, time_s, with_stage(callbacks, "lifting", rise));
      failed(moved))
    return ended_from_outside(moved) ? moved : let_go(hand, name, moved);
  // Closing again shows whether the object is still held; it moves only empty fingers.
  const auto still = hand.gripper->close(callbacks);
  if (!still) return still.error();
  if (!*still) {
    (void)change(SceneObject::REMOVE, name, nullptr);
    return {ArmCode::kObjectLost, name + " slipped out of the " + hand.names.name + " gripper"};
  }
  return success();
}

// Motions.

Grasper::Maybe<arm::MotionRequest> Grasper::request(const Hand& hand, double time_s) const {
  const auto positions = execution_.shared().robot_state.positions();
  if (!positions) return tl::unexpected(positions.error());
  const auto& params = execution_.shared().params;
  arm::MotionRequest request;
  request.group = hand.names.group;
  request.start = *positions;
  request.planning_time_s = time_s;
  request.velocity_scale = params.velocity_scale;
  request.acceleration_scale = params.acceleration_scale;
  return request;
}

Status Grasper::move_joints(const Hand& hand, const JointPositions& goal, double time_s,
                            const MotionCallbacks& callbacks) {
  auto asked = request(hand, time_s);
  if (!asked) return asked.error();
  asked->goal = goal;
  return execution_.move(std::move(*asked), 2, callbacks).status;
}

/// Close to objects, therefore slowly.
Status Grasper::move_along(const Hand& hand, const std::vector<JointVector>& path, double time_s,
                           const MotionCallbacks& callbacks) {
  auto asked = request(hand, time_s);
  if (!asked) return asked.error();
  if (path.empty()) return {ArmCode::kInternal, "a path is missing"};
  asked->path = path;
  asked->velocity_scale *= execution_.shared().params.grasp.slow;
  return execution_.move(std::move(*asked), 0, callbacks).status;
}

Status Grasper::change(std::uint8_t operation, const std::string& name, const Hand* hand) {
  SceneObject message;
  message.operation = operation;
  message.name = name;
  if (hand != nullptr) {
    message.link = hand->names.tip;
    message.touch_links = hand->shape.finger_links;
  }
  const auto done = execution_.shared().scene.apply({message});
  return done ? success() : done.error();
}

Grasper::Maybe<Pose> Grasper::tip_now(const Hand& hand) const {
  return execution_.shared().transforms.root_T_frame(hand.names.tip, ros::Time());
}

}  // namespace extperfc::arm_node
