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

Grasper::Maybe<Grasper::Hand*> Grasper::holding(const extperfc::PlaceGoal& goal, CollisionObject* item) {
  bool known = goal.arm.empty();
  for (auto& hand : hands_) {
    if (!goal.arm.empty() && hand.names.name != goal.arm) continue;
    known = true;
    const auto held = execution_.shared().scene.held_by(hand.names.tip);
    if (!held || (!goal.object.empty() && held->name != goal.object && held->label != goal.object)) continue;
    *item = *held;
    return &hand;
  }
  if (!known) return failure(ArmCode::kInvalidRequest, "unknown gripper '" + goal.arm + "'");
  return failure(ArmCode::kNothingHeld,
                 goal.object.empty() ? "no gripper holds an object" : "no gripper holds " + goal.object);
}

Status Grasper::place(const extperfc::PlaceGoal& goal, const MotionCallbacks& callbacks,
                      extperfc::PlaceResult& result) {
  const auto& params = execution_.shared().params;
  if (!(goal.retreat >= 0.0) || goal.retreat > 0.5)
    return {ArmCode::kInvalidRequest, "retreat must be from 0 to 0.5 m"};
  if (!(goal.planning_time >= 0.0)) return {ArmCode::kInvalidRequest, "planning_time must be 0 s or more"};
  callbacks.progress("choosing", 0.0);
  CollisionObject item;
  const auto hand = holding(goal, &item);
  if (!hand) return hand.error();
  const auto target = execution_.shared().transforms.root_T_pose(goal.pose);
  if (!target) return target.error();
  const auto carrying = execution_.shared().scene.world();
  if (!carrying) return carrying.error();
  const PlacePoseSearch search{or_else(goal.retreat, params.grasp.retreat_m), params.planning_time_s, true,
                               (*hand)->put_down};
  const auto place_pose =
      choose_place_pose(**hand, item, *carrying, *target, goal.any_yaw != 0, search, callbacks);
  if (!place_pose) return place_pose.error();
  auto status =
      put_down(**hand, item, *place_pose, or_else(goal.planning_time, params.planning_time_s), callbacks);
  if (failed(status)) return status;
  result.placed.header.frame_id = execution_.shared().arms.root_link();
  result.placed.header.stamp = ros::Time::now();
  result.placed.pose = convert::to_message(place_pose->where.root_T_object);
  return status;
}

Grasper::Maybe<Grasper::PlacePose> Grasper::choose_place_pose(const Hand& hand, const CollisionObject& item,
                                                              const arm::CollisionWorld& carrying,
                                                              const Pose& root_T_object, bool any_yaw,
                                                              const PlacePoseSearch& search,
                                                              const MotionCallbacks& callbacks) {
  arm::PlaceRequest request;
  request.tip_T_object = item.frame_T_object;
  request.root_T_object = root_T_object;
  request.any_yaw = any_yaw;
  request.opening_m = hand.shape.opening_max_m;
  request.support_z_m = heights(item.shapes, root_T_object).first;
  const double lower_m = execution_.shared().params.grasp.lower_m;
  const double less_lower_m = std::min(lower_m, std::max(0.02, kMinApproach * lower_m));
  struct Strategy {
    arm::PlaceParams how;
    bool padded;
    bool hard{false};
  };
  // First with padding, then without, then with more yaw angles and postures, then with a shorter descent.
  // The retreat is never shortened: the fingers have to leave the object.
  std::vector<Strategy> strategies{Strategy{{lower_m, search.retreat_m, 0.3927, 0.002}, true},
                                   Strategy{{lower_m, search.retreat_m, 0.3927, 0.002}, false}};
  if (search.reserve) {
    strategies.push_back({{lower_m, search.retreat_m, 0.1963, 0.002}, false, true});
    strategies.push_back({{less_lower_m, search.retreat_m, 0.1963, 0.002}, false, true});
  }
  Status last;
  for (const auto& strategy : strategies) {
    const auto candidates = place_candidates(hand.shape, item, request, strategy.how);
    if (!candidates) return failure(ArmCode::kGoalUnreachable, candidates.error().message);
    PlacePoseAttempt how{strategy.padded, {}, search.starts};
    how.options.timeout_s = search.time_s;
    how.options.cancelled = [&callbacks] { return callbacks.cancel.cancelled(); };
    if (strategy.hard) {
      how.options.ik_restarts = 100;
      how.options.ik_timeout_s = 0.05;
      how.options.postures = 8;
    }
    auto place_pose = choose_place_pose(hand, item, carrying, *candidates, how, callbacks);
    if (place_pose || place_pose.error().code != ArmCode::kGoalUnreachable) return place_pose;
    last = place_pose.error();
  }
  return tl::unexpected(last);
}

Grasper::Maybe<Grasper::PlacePose> Grasper::choose_place_pose(
    const Hand& hand, const CollisionObject& item, arm::CollisionWorld carrying,
    const std::vector<arm::PlaceCandidate>& candidates, const PlacePoseAttempt& how,
    const MotionCallbacks& callbacks) {
  const auto& shared = execution_.shared();
  const auto positions = shared.robot_state.positions();
  if (!positions) return tl::unexpected(positions.error());
  auto empty = carrying;
  allow_support(carrying, item.name, heights(item.shapes, candidates.front().root_T_object).first);
  empty.remove(item.name);
  const auto& group = **shared.arms.group(hand.names.group);
  const auto state = arm::RobotArms::select(group, *positions);
  if (!state) return failure(ArmCode::kNoJointStates, state.error().message);
  auto full = execution_.pipeline().checker(group.name, *positions, carrying, how.padded);
  auto after = execution_.pipeline().checker(group.name, *positions, empty, how.padded);
  if (!full || !after) return failure(ArmCode::kInternal, (full ? after : full).error().message);
  Paths backs;
  // Down with the object (planned backwards, from below), back without it. The pose above identifies the
  // candidate.
  const auto motions = [&](const JointVector& low,
                           const Pose& root_T_above) -> std::optional<std::vector<JointVector>> {
    auto down = arm::CartesianPlanner::make(*full, hand.kinematics.chain(), quick());
    auto back = arm::CartesianPlanner::make(*after, hand.kinematics.chain(), quick());
    if (!down || !back) return std::nullopt;
    auto descent = down->plan({low, {root_T_above}, {}});
    if (descent.end != arm::CartesianEnd::kComplete) return std::nullopt;
    for (const auto& one : candidates) {
      if (!one.root_T_above.isApprox(root_T_above, 1e-9)) continue;
      auto retreat = back->plan({low, {one.root_T_retreat}, {}});
      if (retreat.end != arm::CartesianEnd::kComplete) return std::nullopt;
      backs.push_back(std::move(retreat.waypoints));
    }
    return std::move(descent.waypoints);
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
      poses, {{hand.names.name, &hand.kinematics, &*full, *state, nullptr, motions, how.starts}},
      how.options);
  if (const auto reason = callbacks.cancel.reason()) return tl::unexpected(*reason);
  if (!chosen)
    return failure(ArmCode::kGoalUnreachable,
                   "cannot place " + item.name + " there: " + chosen.error().message);
  PlacePose place_pose;
  place_pose.where = candidates[static_cast<std::size_t>(chosen->candidate)];
  place_pose.down = chosen->path;
  place_pose.back = path_from(backs, chosen->path.back());
  place_pose.above = by_name(hand.kinematics.chain(), chosen->pregrasp);
  return place_pose;
}

/// Called for many grasps, therefore with a small time limit.
std::optional<JointVector> Grasper::placed(const Hand& hand, const CollisionObject& item,
                                           const Pose& root_T_tip, const PlaceRequirement& requirement,
                                           const MotionCallbacks& callbacks) {
  constexpr double kTime_s = 0.3;
  auto carrying = execution_.shared().scene.world();
  if (!carrying) return std::nullopt;
  CollisionObject held = item;
  held.frame_T_object = root_T_tip.inverse() * item.frame_T_object;
  carrying->remove(item.name);
  const auto done = carrying->attach(
      {item.name, hand.names.tip, item.shapes, held.frame_T_object, hand.shape.finger_links});
  if (!done) return std::nullopt;
  const PlacePoseSearch search{execution_.shared().params.grasp.retreat_m, kTime_s, false, {}};
  for (const Pose& root_T_place : requirement.root_T_places)
    if (const auto place_pose =
            choose_place_pose(hand, held, *carrying, root_T_place, requirement.any_yaw, search, callbacks))
      return place_pose->down.back();
  return std::nullopt;
}

Status Grasper::put_down(Hand& hand, const CollisionObject& item, const PlacePose& place_pose, double time_s,
                         const MotionCallbacks& callbacks) {
  const auto still = execution_.shared().scene.hold(item.name);  // until the fingers have left it
  const double bottom = heights(item.shapes, place_pose.where.root_T_object).first;
  const auto stand = [&](arm::CollisionWorld& world) { allow_support(world, item.name, bottom); };
  if (auto moved = move_joints(hand, place_pose.above, time_s, with_stage(callbacks, "carrying", {}));
      failed(moved))
    return moved;
  if (auto moved = move_along(hand, place_pose.down, time_s, with_stage(callbacks, "lowering", stand));
      failed(moved))
    return moved;
  callbacks.progress("releasing", 0.0);
  if (auto opened = hand.gripper->open(callbacks); !opened) return opened.error();
  if (auto done = change(SceneObject::DETACH, item.name, nullptr); failed(done)) return done;
  const auto touch = [&](arm::CollisionWorld& world) { arm::allow_grasp(world, item.name, hand.shape); };
  return move_along(hand, place_pose.back, time_s, with_stage(callbacks, "retreating", touch));
}

}  // namespace extperfc::arm_node
