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

constexpr double kLeastLift = 0.75;  ///< share of the lift that is one
constexpr std::size_t kMostPlaces = 10;

/// Ended by somebody or by the robot itself: nothing more is to move.
bool ended_from_outside(const Ending& ending) {
  return ending.code == ArmCode::kCancelled || ending.code == ArmCode::kPreempted ||
         ending.code == ArmCode::kRobotStopped || ending.code == ArmCode::kRobotNotEnabled;
}

}  // namespace

Result<std::unique_ptr<Grasper>> Grasper::make(const ros::NodeHandle& handle, Commander& commander) {
  const auto& shared = commander.shared();
  std::vector<Hand> hands;
  for (const auto& names : shared.params.hands) {
    const auto wrong = [&](const Error& error) {
      return fail(error.code, "hand " + names.name + ": " + error.message);
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
  return std::unique_ptr<Grasper>(new Grasper(commander, std::move(hands)));
}

// Pick.

Grasper::Maybe<std::vector<Grasper::Hand*>> Grasper::free_hands(const std::string& arm) {
  std::vector<Hand*> found;
  bool known = false;
  for (auto& hand : hands_) {
    if (!arm.empty() && hand.names.name != arm) continue;
    known = true;
    if (!commander_.shared().scene.held_by(hand.names.tip)) found.push_back(&hand);
  }
  if (!known) return end(ArmCode::kInvalidRequest, "there is no hand '" + arm + "'");
  if (found.empty())
    return end(ArmCode::kHandsFull, (arm.empty() ? "every hand" : arm + " hand") + " holds something");
  return found;
}

Grasper::Maybe<Grasper::Choice> Grasper::choose(const extperfc::PickGoal& goal, const Hooks& hooks) {
  if (goal.object.empty()) return end(ArmCode::kInvalidRequest, "no object is named");
  const auto hands = free_hands(goal.arm);
  if (!hands) return tl::unexpected(hands.error());
  const auto errand = errand_of(goal);
  if (!errand) return tl::unexpected(errand.error());
  auto items = commander_.shared().scene.find(goal.object);
  if (!items) return tl::unexpected(items.error());
  items->erase(std::remove_if(items->begin(), items->end(), [](const SceneItem& item) { return item.held; }),
               items->end());
  if (items->empty()) return end(ArmCode::kUnknownObject, "'" + goal.object + "' is held already");
  std::stable_sort(items->begin(), items->end(), [](const SceneItem& a, const SceneItem& b) {
    return a.frame_T_object.translation().head<2>().norm() < b.frame_T_object.translation().head<2>().norm();
  });
  const auto& wanted = commander_.shared().params.grasp.grasp;
  const double lift_m = or_else(goal.lift, wanted.lift_m);
  // First with room for everything, then with less and more directions to come from.
  const std::array<Room, 2> rooms{
      Room{wanted.approach_m, lift_m, wanted.tilt_step_rad, true},
      Room{std::max(0.02, kLeastApproach * wanted.approach_m), kLeastLift * lift_m,
           std::max(0.05, 0.5 * wanted.tilt_step_rad), false}};
  Ending last;
  int tried = 0;
  for (const auto& room : rooms)
    for (const auto& item : *items) {
      auto choice = choose(item, *hands, room, *errand, hooks);
      if (choice) return choice->tried += tried, choice;
      last = choice.error();
      if (last.code != ArmCode::kNoGrasp) return tl::unexpected(last);
    }
  return tl::unexpected(last);
}

Grasper::Maybe<Grasper::Choice> Grasper::choose(const SceneItem& item, const std::vector<Hand*>& hands,
                                                const Room& room, const Errand& errand, const Hooks& hooks) {
  const auto& shared = commander_.shared();
  if (item.shapes.size() != 1)
    return end(ArmCode::kNoGrasp, item.name + " has " + std::to_string(item.shapes.size()) +
                                      " shapes; things of one shape can be grasped");
  std::deque<Reach> reaches;  // what refers to them stays good
  std::string why;
  for (Hand* hand : hands) {
    auto reach = reach_of(*hand, item, room);
    if (reach)
      reaches.push_back(std::move(*reach));
    else if (reach.error().code != ArmCode::kNoGrasp)
      return tl::unexpected(reach.error());
    else
      why += (why.empty() ? "" : "; ") + hand->names.name + ": " + reach.error().message;
  }
  if (reaches.empty()) return end(ArmCode::kNoGrasp, item.name + ": " + why);
  std::vector<arm::GraspArm> arms;
  arms.reserve(reaches.size());
  for (auto& reach : reaches)
    arms.push_back({reach.hand->names.name, &reach.hand->kinematics, &reach.checker, reach.state,
                    &reach.grasps, ways_to_place(item, reach, room.lift_m, errand, hooks)});
  arm::GraspChoiceOptions options;
  options.timeout_s = shared.params.planning_time_s;
  options.cancelled = [&hooks] { return hooks.interrupted && hooks.interrupted().has_value(); };
  const auto chosen = arm::choose_grasp({}, arms, options);
  if (hooks.interrupted)
    if (const auto ended = hooks.interrupted()) return tl::unexpected(*ended);
  if (!chosen)
    return end(ArmCode::kNoGrasp, item.name + ": " + chosen.error().message +
                                      (errand.root_T_places.empty() ? "" : "; it has to be put down, too"));
  const Reach& reach = reaches[static_cast<std::size_t>(chosen->arm)];
  Choice choice;
  choice.hand = reach.hand;
  choice.item = item;
  choice.grasp = reach.grasps[static_cast<std::size_t>(chosen->candidate)];
  choice.tried = chosen->tried;
  choice.approach = chosen->way;
  choice.lift = way_on(reach.lifts, chosen->way.back());
  choice.put_down = reach.put_down;
  choice.pregrasp = by_name(reach.hand->kinematics.chain(), chosen->pregrasp);
  return choice;
}

Grasper::Maybe<Grasper::Reach> Grasper::reach_of(Hand& hand, const SceneItem& item, const Room& room) {
  const auto& shared = commander_.shared();
  arm::GraspObject object;
  object.geometry = item.shapes.front().geometry;
  object.root_T_object = item.frame_T_object * item.shapes.front().body_T_shape;
  object.support_z_m = heights(object.geometry, object.root_T_object).first;
  auto params = shared.params.grasp.grasp;
  params.approach_m = room.approach_m;
  params.tilt_step_rad = room.tilt_step_rad;
  params.most_candidates = 400;
  auto grasps = arm::generate_grasps(hand.shape, object, params);
  if (!grasps) return end(ArmCode::kNoGrasp, grasps.error().message);
  auto open = shared.watch.positions();
  if (!open) return tl::unexpected(open.error());
  const auto finger = shared.arms.robot().joint(hand.names.finger_joint);
  (*open)[hand.names.finger_joint] = shared.arms.robot().joints()[static_cast<std::size_t>(*finger)].upper;
  auto world = shared.scene.world();
  if (!world) return tl::unexpected(world.error());
  arm::allow_grasp(*world, item.name, hand.shape);
  auto checker = commander_.pipeline().checker(hand.names.group, *open, *world, room.padded);
  if (!checker) return end(ArmCode::kInternal, checker.error().message);
  const auto state = arm::RobotArms::select(**shared.arms.group(hand.names.group), *open);
  if (!state) return end(ArmCode::kNoJointStates, state.error().message);
  return Reach{&hand, std::move(*grasps), std::move(*checker), *state, {}, {}};
}

arm::StraightWay Grasper::straight_ways(Reach& reach, double lift_m) const {
  // Asked for from the grasp back to the pregrasp.
  return [&reach, lift_m](const JointVector& grasp,
                          const Pose& root_T_pregrasp) -> std::optional<std::vector<JointVector>> {
    const auto& chain = reach.hand->kinematics.chain();
    auto planner = arm::CartesianPlanner::make(reach.checker, chain, quick());
    if (!planner) return std::nullopt;
    auto way = planner->plan({grasp, {root_T_pregrasp}, {}});
    if (way.end != arm::CartesianEnd::kComplete) return std::nullopt;
    Pose lifted = chain.forward(grasp);
    lifted.translation().z() += lift_m;
    auto up = planner->plan({grasp, {lifted}, {}});
    if (up.end != arm::CartesianEnd::kComplete) return std::nullopt;
    reach.lifts.push_back(std::move(up.waypoints));
    return std::move(way.waypoints);
  };
}

arm::StraightWay Grasper::ways_to_place(const SceneItem& item, Reach& reach, double lift_m,
                                        const Errand& errand, const Hooks& hooks) {
  auto ways = straight_ways(reach, lift_m);
  if (errand.root_T_places.empty()) return ways;
  // A candidate is asked for in several postures; where the thing can be put does not depend on them.
  std::optional<std::pair<Pose, bool>> last;
  return [this, &item, &reach, &errand, &hooks, ways = std::move(ways), last](
             const JointVector& grasp,
             const Pose& root_T_pregrasp) mutable -> std::optional<std::vector<JointVector>> {
    const bool known = last && last->first.isApprox(root_T_pregrasp, 1e-9);
    if (known && !last->second) return std::nullopt;
    auto way = ways(grasp, root_T_pregrasp);
    if (!way || known) return way;
    const Pose root_T_tip = reach.hand->kinematics.chain().forward(grasp);
    const auto there = placed(*reach.hand, item, root_T_tip, errand, hooks);
    last.emplace(root_T_pregrasp, there.has_value());
    if (!there) return std::nullopt;
    reach.put_down = {*there};
    return way;
  };
}

Grasper::Maybe<Grasper::Errand> Grasper::errand_of(const extperfc::PickGoal& goal) const {
  if (goal.place_at.size() > kMostPlaces)
    return end(ArmCode::kInvalidRequest, "place_at: " + std::to_string(kMostPlaces) + " places at most");
  Errand errand;
  errand.any_yaw = goal.place_any_yaw != 0;
  for (const auto& place : goal.place_at) {
    const auto root_T_place = commander_.shared().frames.root_T_pose(place);
    if (!root_T_place) return end(root_T_place.error().code, "place_at: " + root_T_place.error().message);
    errand.root_T_places.push_back(*root_T_place);
  }
  return errand;
}

/// Opens the hand where it is; the thing is in the scene again.
Ending Grasper::let_go(Hand& hand, const std::string& name, const Ending& why) {
  if (auto opened = hand.gripper->open({}); !opened)
    return {why.code, why.message + "; the hand does not open: " + opened.error().message};
  if (auto done = change(SceneObject::DETACH, name, nullptr); failed(done))
    return {why.code, why.message + "; " + done.message};
  return {why.code, why.message + "; the hand let go"};
}

Ending Grasper::pick(const extperfc::PickGoal& goal, const Hooks& hooks, extperfc::PickResult& result) {
  const auto& params = commander_.shared().params;
  if (!(goal.lift >= 0.0) || goal.lift > 1.0)
    return {ArmCode::kInvalidRequest, "the lift must be from 0 to 1 m"};
  if (!(goal.planning_time >= 0.0))
    return {ArmCode::kInvalidRequest, "the planning time must be 0 s or more"};
  hooks.progress("choosing", 0.0);
  if (const auto obstacle = commander_.shared().watch.obstacle()) return *obstacle;
  // From looking at it until it is in the hand, fingers hide it and push it.
  auto still = commander_.shared().scene.hold(goal.object);
  const auto choice = choose(goal, hooks);
  if (!choice) return choice.error();
  still = commander_.shared().scene.hold(choice->item.name);
  result.object = choice->item.name;
  result.arm = choice->hand->names.name;
  result.grasps = static_cast<std::uint32_t>(choice->tried);
  return grasp(*choice, or_else(goal.planning_time, params.planning_time_s), hooks, result);
}

Ending Grasper::grasp(const Choice& choice, double time_s, const Hooks& hooks, extperfc::PickResult& result) {
  Hand& hand = *choice.hand;
  const std::string& name = choice.item.name;
  hand.put_down = choice.put_down;
  if (auto opened = hand.gripper->open(hooks); !opened) return opened.error();
  if (auto moved = move_joints(hand, choice.pregrasp, time_s, with(hooks, "approaching", {})); failed(moved))
    return moved;
  const auto touch = [&](arm::CollisionWorld& world) { arm::allow_grasp(world, name, hand.shape); };
  if (auto moved = move_along(hand, choice.approach, time_s, with(hooks, "approaching", touch));
      failed(moved))
    return moved;
  hooks.progress("grasping", 0.0);
  const auto tip = tip_now(hand);
  if (!tip) return tip.error();
  result.grasp.header.frame_id = commander_.shared().arms.root_link();
  result.grasp.header.stamp = ros::Time::now();
  result.grasp.pose = convert::to_message(*tip);
  const auto holds = hand.gripper->close(hooks);
  if (!holds) return holds.error();
  if (!*holds) {
    (void)hand.gripper->open(hooks);
    return {ArmCode::kGraspMissed, "the hand closed on nothing where " + name + " should be"};
  }
  if (auto done = change(SceneObject::ATTACH, name, &hand); failed(done)) return done;
  const double bottom = heights(choice.item.shapes, choice.item.frame_T_object).first;
  const auto rise = [&](arm::CollisionWorld& world) { allow_support(world, name, bottom); };
  if (auto moved = move_along(hand, choice.lift, time_s, with(hooks, "lifting", rise)); failed(moved))
    return ended_from_outside(moved) ? moved : let_go(hand, name, moved);
  // Closing again moves nothing when something is held, and tells.
  const auto still = hand.gripper->close(hooks);
  if (!still) return still.error();
  if (!*still) {
    (void)change(SceneObject::REMOVE, name, nullptr);
    return {ArmCode::kObjectLost, name + " slipped out of the " + hand.names.name + " hand"};
  }
  return success();
}

// Motions.

Grasper::Maybe<arm::MotionRequest> Grasper::request(const Hand& hand, double time_s) const {
  const auto positions = commander_.shared().watch.positions();
  if (!positions) return tl::unexpected(positions.error());
  const auto& params = commander_.shared().params;
  arm::MotionRequest request;
  request.group = hand.names.group;
  request.start = *positions;
  request.planning_time_s = time_s;
  request.velocity_scale = params.velocity_scale;
  request.acceleration_scale = params.acceleration_scale;
  return request;
}

Ending Grasper::move_joints(const Hand& hand, const JointPositions& goal, double time_s, const Hooks& hooks) {
  auto asked = request(hand, time_s);
  if (!asked) return asked.error();
  asked->goal = goal;
  return commander_.move(std::move(*asked), 2, hooks).ending;
}

/// Near things, so slowly.
Ending Grasper::move_along(const Hand& hand, const std::vector<JointVector>& path, double time_s,
                           const Hooks& hooks) {
  auto asked = request(hand, time_s);
  if (!asked) return asked.error();
  if (path.empty()) return {ArmCode::kInternal, "a way is missing"};
  asked->path = path;
  asked->velocity_scale *= commander_.shared().params.grasp.slow;
  return commander_.move(std::move(*asked), 0, hooks).ending;
}

Ending Grasper::change(std::uint8_t operation, const std::string& name, const Hand* hand) {
  SceneObject message;
  message.operation = operation;
  message.name = name;
  if (hand != nullptr) {
    message.link = hand->names.tip;
    message.touch_links = hand->shape.finger_links;
  }
  const auto done = commander_.shared().scene.apply({message});
  return done ? success() : done.error();
}

Grasper::Maybe<Pose> Grasper::tip_now(const Hand& hand) const {
  return commander_.shared().frames.root_T_frame(hand.names.tip, ros::Time());
}

}  // namespace extperfc::arm_node
