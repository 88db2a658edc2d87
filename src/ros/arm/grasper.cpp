#include "ros/arm/grasper.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <variant>

#include "extperfc/arm/cartesian_path.hpp"

#include "ros/convert/arm.hpp"
#include "ros/convert/geometry.hpp"

namespace extperfc::arm_node {

using arm::ArmCode;
using arm::JointPositions;
using arm::JointVector;
using extperfc::SceneObject;

namespace {

constexpr double kLeastLift = 0.75;     ///< share of the lift that is one
constexpr double kLeastApproach = 0.5;  ///< share of approach and lowering where there is no room for all
constexpr double kBelow = 0.01;  ///< things whose top is at most so much above a thing's bottom carry it [m]

/// Lowest and highest z of a shape at a pose.
std::pair<double, double> heights(const Geometry& geometry, const Pose& root_T_shape) {
  const Eigen::Vector3d up = root_T_shape.linear().transpose().col(2);  // the root's z in the shape's frame
  double half = 0;
  if (const auto* box = std::get_if<Box>(&geometry))
    half = 0.5 * up.cwiseAbs().dot(box->size_m);
  else if (const auto* sphere = std::get_if<Sphere>(&geometry))
    half = sphere->radius_m;
  else if (const auto* cylinder = std::get_if<Cylinder>(&geometry))
    half = 0.5 * cylinder->length_m * std::abs(up.z()) + cylinder->radius_m * std::hypot(up.x(), up.y());
  else if (const auto* cone = std::get_if<Cone>(&geometry))
    half = 0.5 * cone->height_m * std::abs(up.z()) + cone->radius_m * std::hypot(up.x(), up.y());
  const double z = root_T_shape.translation().z();
  const auto* mesh = std::get_if<TriangleMesh>(&geometry);
  if (mesh == nullptr || !mesh->triangles) return {z - half, z + half};
  std::pair<double, double> all{std::numeric_limits<double>::infinity(),
                                -std::numeric_limits<double>::infinity()};
  for (const auto& triangle : *mesh->triangles)
    for (const auto& corner : triangle) {
      const double at = z + up.dot(corner.cast<double>().cwiseProduct(mesh->scale));
      all = {std::min(all.first, at), std::max(all.second, at)};
    }
  return all;
}

std::pair<double, double> heights(const std::vector<Shape>& shapes, const Pose& root_T_object) {
  std::pair<double, double> all{std::numeric_limits<double>::infinity(),
                                -std::numeric_limits<double>::infinity()};
  for (const auto& shape : shapes) {
    const auto one = heights(shape.geometry, root_T_object * shape.body_T_shape);
    all = {std::min(all.first, one.first), std::max(all.second, one.second)};
  }
  return all;
}

/// The thing may touch what ends below its lower side: what it stands on.
void allow_support(arm::CollisionWorld& world, const std::string& thing, double bottom_z_m) {
  std::vector<std::string> below;
  for (const auto& [name, placed] : world.objects())
    if (name != thing &&
        heights(placed->object.shapes, placed->object.root_T_object).second <= bottom_z_m + kBelow)
      below.push_back(name);
  for (const auto& name : below) world.allow(thing, name);
}

Hooks with(const Hooks& hooks, const char* stage, std::function<void(arm::CollisionWorld&)> allow) {
  Hooks changed = hooks;
  changed.allow = std::move(allow);
  const auto report = hooks.progress;
  changed.progress = [report, stage](const std::string&, double executed) {
    if (report) report(stage, executed);
  };
  return changed;
}

/// The way that starts where another one ended; empty when there is none.
std::vector<JointVector> way_on(const std::vector<std::vector<JointVector>>& ways, const JointVector& from) {
  for (const auto& way : ways)
    if (way.front().isApprox(from, 1e-9)) return way;
  return {};
}

/// The request, and for a ball, which stands in any orientation, others in which the hand comes from straight
/// down to nearly level.
std::vector<arm::PlaceRequest> turned_requests(const SceneItem& item, arm::PlaceRequest request) {
  const bool ball = item.shapes.size() == 1 && std::holds_alternative<Sphere>(item.shapes.front().geometry) &&
                    item.shapes.front().body_T_shape.translation().norm() < 1e-6;
  if (!ball) return {request};
  request.any_yaw = true;
  std::vector<arm::PlaceRequest> all{request};
  const Eigen::Matrix3d tip = request.root_T_object.linear() * request.tip_T_object.linear().transpose();
  const Eigen::Vector3d down = -Eigen::Vector3d::UnitZ();
  const double tilt = std::acos(std::clamp(tip.col(2).dot(down), -1.0, 1.0));
  const Eigen::Vector3d across = tip.col(2).cross(down);
  const Eigen::Vector3d axis = across.norm() > 1e-3 ? across.normalized() : tip.col(0);
  for (const double wanted : {0.0, 0.4, 0.8, 1.2}) {
    all.push_back(request);
    all.back().root_T_object.linear() =
        Eigen::AngleAxisd(tilt - wanted, axis).toRotationMatrix() * request.root_T_object.linear();
  }
  return all;
}

/// Of all these; the error of the request itself where there are none.
Result<std::vector<arm::PlaceCandidate>> place_candidates(const arm::ParallelHand& hand,
                                                          const SceneItem& item,
                                                          const arm::PlaceRequest& request,
                                                          const arm::PlaceParams& params) {
  std::vector<arm::PlaceCandidate> all;
  std::optional<Error> first;
  for (const auto& turned : turned_requests(item, request)) {
    auto some = arm::place_poses(hand, turned, params);
    if (some)
      all.insert(all.end(), some->begin(), some->end());
    else if (!first)
      first = some.error();
  }
  if (all.empty()) return tl::unexpected(*first);
  return all;
}

/// Ended by somebody or by the robot itself: nothing more is to move.
bool ended_from_outside(const Ending& ending) {
  return ending.code == ArmCode::kCancelled || ending.code == ArmCode::kPreempted ||
         ending.code == ArmCode::kRobotStopped || ending.code == ArmCode::kRobotNotEnabled;
}

/// Many candidates are tried: none shall cost much.
arm::CartesianParams quick() {
  arm::CartesianParams params;
  params.max_attempts = 4;
  params.timeout_s = 0.1;
  return params;
}

Ending success() {
  return {ArmCode::kSuccess, ""};
}

bool failed(const Ending& ending) {
  return ending.code != ArmCode::kSuccess;
}

double or_else(double value, double instead) {
  return value == 0.0 ? instead : value;
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
        {names, std::move(*shape), arm::InverseKinematics(std::move(*chain)),
         std::make_unique<Gripper>(handle, names.action,
                                   Gripper::Params{grasp.effort_percent, grasp.gripper_timeout_s})});
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
      auto choice = choose(item, *hands, room, hooks);
      if (choice) return choice->tried += tried, choice;
      last = choice.error();
      if (last.code != ArmCode::kNoGrasp) return tl::unexpected(last);
    }
  return tl::unexpected(last);
}

Grasper::Maybe<Grasper::Choice> Grasper::choose(const SceneItem& item, const std::vector<Hand*>& hands,
                                                const Room& room, const Hooks& hooks) {
  const auto& shared = commander_.shared();
  if (item.shapes.size() != 1)
    return end(ArmCode::kNoGrasp, item.name + " has " + std::to_string(item.shapes.size()) +
                                      " shapes; things of one shape can be grasped");
  auto positions = shared.watch.positions();
  if (!positions) return tl::unexpected(positions.error());
  auto world = shared.scene.world();
  if (!world) return tl::unexpected(world.error());
  arm::GraspObject object;
  object.geometry = item.shapes.front().geometry;
  object.root_T_object = item.frame_T_object * item.shapes.front().body_T_shape;
  object.support_z_m = heights(object.geometry, object.root_T_object).first;
  auto params = shared.params.grasp.grasp;
  params.approach_m = room.approach_m;
  params.tilt_step_rad = room.tilt_step_rad;
  params.most_candidates = 400;
  std::vector<std::vector<arm::GraspCandidate>> grasps(hands.size());
  std::vector<arm::CollisionChecker> checkers;
  checkers.reserve(hands.size());
  std::vector<WaysOn> lifts(hands.size());
  std::vector<arm::GraspArm> arms;
  std::string why;
  for (std::size_t i = 0; i < hands.size(); ++i) {
    const Hand& hand = *hands[i];
    auto made = arm::generate_grasps(hand.shape, object, params);
    if (!made) {
      why += (why.empty() ? "" : "; ") + hand.names.name + ": " + made.error().message;
      continue;
    }
    grasps[i] = std::move(*made);
    auto open = *positions;
    const auto& joints = shared.arms.robot().joints();
    const auto finger = shared.arms.robot().joint(hand.names.finger_joint);
    open[hand.names.finger_joint] = joints[static_cast<std::size_t>(*finger)].upper;
    auto allowed = *world;
    arm::allow_grasp(allowed, item.name, hand.shape);
    auto checker = commander_.pipeline().checker(hand.names.group, open, allowed, room.padded);
    if (!checker) return end(ArmCode::kInternal, checker.error().message);
    checkers.push_back(std::move(*checker));
    const auto state = arm::RobotArms::select(**shared.arms.group(hand.names.group), open);
    if (!state) return end(ArmCode::kNoJointStates, state.error().message);
    arms.push_back({hand.names.name, &hand.kinematics, &checkers.back(), *state, &grasps[i],
                    straight_ways(hand, checkers.back(), room.lift_m, &lifts[i])});
  }
  if (arms.empty()) return end(ArmCode::kNoGrasp, item.name + ": " + why);
  arm::GraspChoiceOptions options;
  options.timeout_s = shared.params.planning_time_s;
  options.cancelled = [&hooks] { return hooks.interrupted && hooks.interrupted().has_value(); };
  const auto chosen = arm::choose_grasp({}, arms, options);
  if (hooks.interrupted)
    if (const auto ended = hooks.interrupted()) return tl::unexpected(*ended);
  if (!chosen) return end(ArmCode::kNoGrasp, item.name + ": " + chosen.error().message);
  const auto& arm = arms[static_cast<std::size_t>(chosen->arm)];
  Choice choice;
  choice.hand =
      *std::find_if(hands.begin(), hands.end(), [&](Hand* hand) { return hand->names.name == arm.name; });
  choice.item = item;
  choice.grasp = (*arm.grasps)[static_cast<std::size_t>(chosen->candidate)];
  choice.tried = chosen->tried;
  choice.approach = chosen->way;
  choice.lift = way_on(
      lifts[static_cast<std::size_t>(std::find(hands.begin(), hands.end(), choice.hand) - hands.begin())],
      chosen->way.back());
  const auto& names = choice.hand->kinematics.chain().joint_names();
  for (std::size_t i = 0; i < names.size(); ++i)
    choice.pregrasp[names[i]] = chosen->pregrasp[static_cast<Eigen::Index>(i)];
  return choice;
}

arm::StraightWay Grasper::straight_ways(const Hand& hand, arm::CollisionChecker& checker, double lift_m,
                                        WaysOn* lifts) const {
  // Asked for from the grasp back to the pregrasp.
  return
      [&hand, &checker, lift_m, lifts](
          const JointVector& grasp, const Pose& root_T_pregrasp) -> std::optional<std::vector<JointVector>> {
        const auto& chain = hand.kinematics.chain();
        auto planner = arm::CartesianPlanner::make(checker, chain, quick());
        if (!planner) return std::nullopt;
        auto way = planner->plan({grasp, {root_T_pregrasp}, {}});
        if (way.end != arm::CartesianEnd::kComplete) return std::nullopt;
        Pose lifted = chain.forward(grasp);
        lifted.translation().z() += lift_m;
        auto up = planner->plan({grasp, {lifted}, {}});
        if (up.end != arm::CartesianEnd::kComplete) return std::nullopt;
        lifts->push_back(std::move(up.waypoints));
        return std::move(way.waypoints);
      };
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

// Place.

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
  arm::PlaceRequest request;
  request.tip_T_object = item.frame_T_object;
  request.root_T_object = *target;
  request.any_yaw = goal.any_yaw != 0;
  request.opening_m = (*hand)->shape.opening_max_m;
  request.support_z_m = heights(item.shapes, *target).first;
  const auto spot = choose_spot(**hand, item, request, or_else(goal.retreat, params.grasp.retreat_m), hooks);
  if (!spot) return spot.error();
  auto ending = put_down(**hand, item, *spot, or_else(goal.planning_time, params.planning_time_s), hooks);
  if (failed(ending)) return ending;
  result.placed.header.frame_id = commander_.shared().arms.root_link();
  result.placed.header.stamp = ros::Time::now();
  result.placed.pose = convert::to_message(spot->where.root_T_object);
  return ending;
}

Grasper::Maybe<Grasper::Spot> Grasper::choose_spot(const Hand& hand, const SceneItem& item,
                                                   const arm::PlaceRequest& request, double retreat_m,
                                                   const Hooks& hooks) {
  const double lower_m = commander_.shared().params.grasp.lower_m;
  const double less_lower_m = std::min(lower_m, std::max(0.02, kLeastApproach * lower_m));
  struct Way {
    arm::PlaceParams how;
    bool padded;
  };
  // First with room for everything, then nearer to things, then from less high and with more turns. The way
  // back is never shortened: the fingers have to leave the thing.
  const std::array<Way, 3> ways{Way{{lower_m, retreat_m, 0.3927, 0.002}, true},
                                Way{{lower_m, retreat_m, 0.3927, 0.002}, false},
                                Way{{less_lower_m, retreat_m, 0.1963, 0.002}, false}};
  Ending last;
  for (const auto& way : ways) {
    const auto candidates = place_candidates(hand.shape, item, request, way.how);
    if (!candidates) return end(ArmCode::kGoalUnreachable, candidates.error().message);
    auto spot = choose_spot(hand, item, *candidates, way.padded, hooks);
    if (spot || spot.error().code != ArmCode::kGoalUnreachable) return spot;
    last = spot.error();
  }
  return tl::unexpected(last);
}

Grasper::Maybe<Grasper::Spot> Grasper::choose_spot(const Hand& hand, const SceneItem& item,
                                                   const std::vector<arm::PlaceCandidate>& candidates,
                                                   bool padded, const Hooks& hooks) {
  const auto& shared = commander_.shared();
  const auto positions = shared.watch.positions();
  if (!positions) return tl::unexpected(positions.error());
  auto carrying = shared.scene.world();
  if (!carrying) return tl::unexpected(carrying.error());
  auto empty = *carrying;
  allow_support(*carrying, item.name, heights(item.shapes, candidates.front().root_T_object).first);
  empty.remove(item.name);
  const auto& group = **shared.arms.group(hand.names.group);
  const auto state = arm::RobotArms::select(group, *positions);
  if (!state) return end(ArmCode::kNoJointStates, state.error().message);
  auto full = commander_.pipeline().checker(group.name, *positions, *carrying, padded);
  auto after = commander_.pipeline().checker(group.name, *positions, empty, padded);
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
  for (const auto& one : candidates) {
    arm::GraspCandidate pose;
    pose.root_T_pregrasp = one.root_T_above;
    pose.root_T_tip = one.root_T_tip;
    pose.score = 1.0;
    poses.push_back(pose);
  }
  arm::GraspChoiceOptions options;
  options.timeout_s = shared.params.planning_time_s;
  options.cancelled = [&hooks] { return hooks.interrupted && hooks.interrupted().has_value(); };
  const auto chosen =
      arm::choose_grasp(poses, {{hand.names.name, &hand.kinematics, &*full, *state, nullptr, ways}}, options);
  if (hooks.interrupted)
    if (const auto ended = hooks.interrupted()) return tl::unexpected(*ended);
  if (!chosen)
    return end(ArmCode::kGoalUnreachable, "no way to put " + item.name + " there: " + chosen.error().message);
  Spot spot;
  spot.where = candidates[static_cast<std::size_t>(chosen->candidate)];
  spot.down = chosen->way;
  spot.back = way_on(backs, chosen->way.back());
  const auto& names = hand.kinematics.chain().joint_names();
  for (std::size_t i = 0; i < names.size(); ++i)
    spot.above[names[i]] = chosen->pregrasp[static_cast<Eigen::Index>(i)];
  return spot;
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
