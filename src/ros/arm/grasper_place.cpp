#include <algorithm>
#include <optional>
#include <utility>

#include "extperfc/arm/cartesian_path.hpp"

#include "ros/arm/grasper.hpp"
#include "ros/arm/grasper_common.hpp"
#include "ros/arm/place_candidates.hpp"
#include "ros/arm/support.hpp"
#include "ros/convert/geometry.hpp"

namespace extperfc::arm_node {

using arm::ArmCode;
using arm::JointVector;
using extperfc::SceneObject;

Grasper::Maybe<Grasper::Hand*> Grasper::holding(const extperfc::PlaceGoal& goal, SceneItem* item) {
  bool known = goal.arm.empty();
  for (auto& hand : hands_) {
    if (!goal.arm.empty() && hand.names.name != goal.arm) continue;
    known = true;
    const auto held = commander_.shared().scene.held_by(hand.names.tip);
    if (!held || (!goal.object.empty() && held->name != goal.object && held->label != goal.object)) continue;
    *item = *held;
    return &hand;
  }
  if (!known) return end(ArmCode::kInvalidRequest, "there is no hand '" + goal.arm + "'");
  return end(ArmCode::kNothingHeld,
             goal.object.empty() ? "no hand holds anything" : "no hand holds " + goal.object);
}

Ending Grasper::place(const extperfc::PlaceGoal& goal, const Hooks& hooks, extperfc::PlaceResult& result) {
  const auto& params = commander_.shared().params;
  if (!(goal.retreat >= 0.0) || goal.retreat > 0.5)
    return {ArmCode::kInvalidRequest, "the retreat must be from 0 to 0.5 m"};
  if (!(goal.planning_time >= 0.0))
    return {ArmCode::kInvalidRequest, "the planning time must be 0 s or more"};
  hooks.progress("choosing", 0.0);
  SceneItem item;
  const auto hand = holding(goal, &item);
  if (!hand) return hand.error();
  const auto target = commander_.shared().frames.root_T_pose(goal.pose);
  if (!target) return target.error();
  const auto carrying = commander_.shared().scene.world();
  if (!carrying) return carrying.error();
  const SpotSearch search{or_else(goal.retreat, params.grasp.retreat_m), params.planning_time_s, true,
                          (*hand)->put_down};
  const auto spot = choose_spot(**hand, item, *carrying, *target, goal.any_yaw != 0, search, hooks);
  if (!spot) return spot.error();
  auto ending = put_down(**hand, item, *spot, or_else(goal.planning_time, params.planning_time_s), hooks);
  if (failed(ending)) return ending;
  result.placed.header.frame_id = commander_.shared().arms.root_link();
  result.placed.header.stamp = ros::Time::now();
  result.placed.pose = convert::to_message(spot->where.root_T_object);
  return ending;
}

Grasper::Maybe<Grasper::Spot> Grasper::choose_spot(const Hand& hand, const SceneItem& item,
                                                   const arm::CollisionWorld& carrying,
                                                   const Pose& root_T_object, bool any_yaw,
                                                   const SpotSearch& search, const Hooks& hooks) {
  arm::PlaceRequest request;
  request.tip_T_object = item.frame_T_object;
  request.root_T_object = root_T_object;
  request.any_yaw = any_yaw;
  request.opening_m = hand.shape.opening_max_m;
  request.support_z_m = heights(item.shapes, root_T_object).first;
  const double lower_m = commander_.shared().params.grasp.lower_m;
  const double less_lower_m = std::min(lower_m, std::max(0.02, kLeastApproach * lower_m));
  struct Way {
    arm::PlaceParams how;
    bool padded;
    bool hard{false};
  };
  // First with room for everything, then nearer to things, then with more turns and more postures, then from
  // less high. The way back is never shortened: the fingers have to leave the thing.
  std::vector<Way> ways{Way{{lower_m, search.retreat_m, 0.3927, 0.002}, true},
                        Way{{lower_m, search.retreat_m, 0.3927, 0.002}, false}};
  if (search.reserve) {
    ways.push_back({{lower_m, search.retreat_m, 0.1963, 0.002}, false, true});
    ways.push_back({{less_lower_m, search.retreat_m, 0.1963, 0.002}, false, true});
  }
  Ending last;
  for (const auto& way : ways) {
    const auto candidates = place_candidates(hand.shape, item, request, way.how);
    if (!candidates) return end(ArmCode::kGoalUnreachable, candidates.error().message);
    SpotTry how{way.padded, {}, search.starts};
    how.options.timeout_s = search.time_s;
    how.options.cancelled = [&hooks] { return hooks.interrupted && hooks.interrupted().has_value(); };
    if (way.hard) {
      how.options.ik_restarts = 100;
      how.options.ik_timeout_s = 0.05;
      how.options.postures = 8;
    }
    auto spot = choose_spot(hand, item, carrying, *candidates, how, hooks);
    if (spot || spot.error().code != ArmCode::kGoalUnreachable) return spot;
    last = spot.error();
  }
  return tl::unexpected(last);
}

Grasper::Maybe<Grasper::Spot> Grasper::choose_spot(const Hand& hand, const SceneItem& item,
                                                   arm::CollisionWorld carrying,
                                                   const std::vector<arm::PlaceCandidate>& candidates,
                                                   const SpotTry& how, const Hooks& hooks) {
  const auto& shared = commander_.shared();
  const auto positions = shared.watch.positions();
  if (!positions) return tl::unexpected(positions.error());
  auto empty = carrying;
  allow_support(carrying, item.name, heights(item.shapes, candidates.front().root_T_object).first);
  empty.remove(item.name);
  const auto& group = **shared.arms.group(hand.names.group);
  const auto state = arm::RobotArms::select(group, *positions);
  if (!state) return end(ArmCode::kNoJointStates, state.error().message);
  auto full = commander_.pipeline().checker(group.name, *positions, carrying, how.padded);
  auto after = commander_.pipeline().checker(group.name, *positions, empty, how.padded);
  if (!full || !after) return end(ArmCode::kInternal, (full ? after : full).error().message);
  WaysOn backs;
  // Down with the thing (asked for from below), back without it; a candidate is known by its pose above.
  const auto ways = [&](const JointVector& low,
                        const Pose& root_T_above) -> std::optional<std::vector<JointVector>> {
    auto down = arm::CartesianPlanner::make(*full, hand.kinematics.chain(), quick());
    auto back = arm::CartesianPlanner::make(*after, hand.kinematics.chain(), quick());
    if (!down || !back) return std::nullopt;
    auto way = down->plan({low, {root_T_above}, {}});
    if (way.end != arm::CartesianEnd::kComplete) return std::nullopt;
    for (const auto& one : candidates) {
      if (!one.root_T_above.isApprox(root_T_above, 1e-9)) continue;
      auto retreat = back->plan({low, {one.root_T_retreat}, {}});
      if (retreat.end != arm::CartesianEnd::kComplete) return std::nullopt;
      backs.push_back(std::move(retreat.waypoints));
    }
    return std::move(way.waypoints);
  };
  std::vector<arm::GraspCandidate> poses;
  poses.reserve(candidates.size());
  for (const auto& one : candidates) {
    arm::GraspCandidate pose;
    pose.root_T_pregrasp = one.root_T_above;
    pose.root_T_tip = one.root_T_tip;
    pose.score = 1.0;
    poses.push_back(pose);
  }
  const auto chosen = arm::choose_grasp(
      poses, {{hand.names.name, &hand.kinematics, &*full, *state, nullptr, ways, how.starts}}, how.options);
  if (hooks.interrupted)
    if (const auto ended = hooks.interrupted()) return tl::unexpected(*ended);
  if (!chosen)
    return end(ArmCode::kGoalUnreachable, "no way to put " + item.name + " there: " + chosen.error().message);
  Spot spot;
  spot.where = candidates[static_cast<std::size_t>(chosen->candidate)];
  spot.down = chosen->way;
  spot.back = way_on(backs, chosen->way.back());
  spot.above = by_name(hand.kinematics.chain(), chosen->pregrasp);
  return spot;
}

/// Asked for one grasp after the other, so it must not take long.
std::optional<JointVector> Grasper::placed(const Hand& hand, const SceneItem& item, const Pose& root_T_tip,
                                           const Errand& errand, const Hooks& hooks) {
  constexpr double kTime_s = 0.3;
  auto carrying = commander_.shared().scene.world();
  if (!carrying) return std::nullopt;
  SceneItem held = item;
  held.frame_T_object = root_T_tip.inverse() * item.frame_T_object;
  carrying->remove(item.name);
  const auto done = carrying->attach(
      {item.name, hand.names.tip, item.shapes, held.frame_T_object, hand.shape.finger_links});
  if (!done) return std::nullopt;
  const SpotSearch search{commander_.shared().params.grasp.retreat_m, kTime_s, false, {}};
  for (const Pose& root_T_place : errand.root_T_places)
    if (const auto spot = choose_spot(hand, held, *carrying, root_T_place, errand.any_yaw, search, hooks))
      return spot->down.back();
  return std::nullopt;
}

Ending Grasper::put_down(Hand& hand, const SceneItem& item, const Spot& spot, double time_s,
                         const Hooks& hooks) {
  const auto still = commander_.shared().scene.hold(item.name);  // until the fingers are away from it
  const double bottom = heights(item.shapes, spot.where.root_T_object).first;
  const auto stand = [&](arm::CollisionWorld& world) { allow_support(world, item.name, bottom); };
  if (auto moved = move_joints(hand, spot.above, time_s, with(hooks, "carrying", {})); failed(moved))
    return moved;
  if (auto moved = move_along(hand, spot.down, time_s, with(hooks, "lowering", stand)); failed(moved))
    return moved;
  hooks.progress("releasing", 0.0);
  if (auto opened = hand.gripper->open(hooks); !opened) return opened.error();
  if (auto done = change(SceneObject::DETACH, item.name, nullptr); failed(done)) return done;
  const auto touch = [&](arm::CollisionWorld& world) { arm::allow_grasp(world, item.name, hand.shape); };
  return move_along(hand, spot.back, time_s, with(hooks, "retreating", touch));
}

}  // namespace extperfc::arm_node
