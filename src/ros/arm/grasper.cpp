#include "ros/arm/grasper.hpp"

#include <algorithm>
#include <functional>
#include <utility>

#include "ros/convert/geometry.hpp"

namespace extperfc::ros_arm {

using arm::ArmCode;
using arm::JointVector;
using extperfc::SceneObject;

namespace {

constexpr std::size_t kMaxPlaces = 10;

Status success() {
  return {ArmCode::kSuccess, ""};
}

bool failed(const Status& status) {
  return status.code != ArmCode::kSuccess;
}

/// Cancelled by a caller or stopped by the robot: the grasper must not move the arm any more.
bool ended_from_outside(const Status& status) {
  return status.code == ArmCode::kCancelled || status.code == ArmCode::kPreempted ||
         status.code == ArmCode::kRobotStopped || status.code == ArmCode::kRobotNotEnabled;
}

/// The callbacks of a part of a motion: its name is reported as the stage.
MotionCallbacks with_stage(const MotionCallbacks& callbacks, const char* stage,
                           std::function<void(arm::CollisionWorld&)> allow) {
  MotionCallbacks changed = callbacks;
  changed.allow = std::move(allow);
  changed.progress = [report = callbacks.progress, stage](const std::string&, double executed) {
    if (report) report(stage, executed);
  };
  return changed;
}

/// The caller's reason to cancel, or else the error of planning.
Status reason_of(const Status& error, const MotionCallbacks& callbacks) {
  return callbacks.cancel.reason().value_or(error);
}

std::function<bool()> cancel_check(const MotionCallbacks& callbacks) {
  return [&callbacks] { return callbacks.cancel.cancelled(); };
}

}  // namespace

Result<std::unique_ptr<Grasper>> Grasper::make(const ros::NodeHandle& handle, PlanExecution& execution) {
  const auto& shared = execution.shared();
  const auto& grasp = shared.params.grasp;
  std::vector<Hand> hands;
  for (const auto& names : shared.params.grippers) {
    auto arm = arm::Manipulator::make(shared.arms, names.name, names.group, names.tip, names.finger_joint);
    if (!arm) return fail(arm.error().code, "gripper " + names.name + ": " + arm.error().message);
    const Gripper::Params params{grasp.effort_percent, grasp.gripper_timeout_s};
    auto gripper = std::make_unique<Gripper>(handle, names.action, params);
    hands.push_back({std::move(*arm), std::move(gripper), {}});
  }
  return std::unique_ptr<Grasper>(new Grasper(execution, std::move(hands)));
}

// Pick.

Grasper::Maybe<std::vector<const arm::Manipulator*>> Grasper::free_arms(const std::string& arm) const {
  std::vector<const arm::Manipulator*> found;
  bool known = false;
  for (const auto& hand : hands_) {
    if (!arm.empty() && hand.manipulator.name != arm) continue;
    known = true;
    if (!execution_.shared().scene.held_by(hand.tip())) found.push_back(&hand.manipulator);
  }
  if (!known) return failure(ArmCode::kInvalidRequest, "unknown gripper '" + arm + "'");
  if (found.empty())
    return failure(
        ArmCode::kGrippersFull,
        (arm.empty() ? "all grippers hold" : "the " + arm + " gripper holds") + std::string(" an object"));
  return found;
}

Grasper::Maybe<std::vector<arm::WorldObject>> Grasper::objects_to_pick(
    const std::string& name_or_label) const {
  const auto items = execution_.shared().scene.find(name_or_label);
  if (!items) return tl::unexpected(items.error());
  std::vector<arm::WorldObject> objects;
  for (const auto& item : *items)
    if (!item.held) objects.push_back({item.name, item.shapes, item.frame_T_object});
  if (objects.empty()) return failure(ArmCode::kUnknownObject, "'" + name_or_label + "' is already held");
  const auto distance = [](const arm::WorldObject& object) {
    return object.root_T_object.translation().head<2>().norm();
  };
  std::stable_sort(objects.begin(), objects.end(),
                   [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  return objects;
}

Grasper::Maybe<arm::PickTask> Grasper::pick_task(const extperfc::PickGoal& goal,
                                                 const MotionCallbacks& callbacks) const {
  if (goal.object.empty()) return failure(ArmCode::kInvalidRequest, "the goal names no object");
  if (goal.place_at.size() > kMaxPlaces)
    return failure(ArmCode::kInvalidRequest, "place_at: at most " + std::to_string(kMaxPlaces) + " poses");
  const auto& shared = execution_.shared();
  auto arms = free_arms(goal.arm);
  if (!arms) return tl::unexpected(arms.error());
  arm::PickTask task;
  task.manipulators = std::move(*arms);
  for (const auto& place : goal.place_at) {
    const auto root_T_place = shared.transforms.root_T_pose(place);
    if (!root_T_place) return failure(root_T_place.error().code, "place_at: " + root_T_place.error().message);
    task.place.root_T_places.push_back(*root_T_place);
  }
  auto objects = objects_to_pick(goal.object);
  if (!objects) return tl::unexpected(objects.error());
  task.objects = std::move(*objects);
  auto positions = shared.robot_state.positions();
  if (!positions) return tl::unexpected(positions.error());
  task.start = std::move(*positions);
  const auto& params = shared.params.grasp;
  task.grasp = params.grasp;
  task.grasp.lift_m = value_or_default(goal.lift, params.grasp.lift_m);
  task.place.any_yaw = goal.place_any_yaw != 0;
  task.place.lower_m = params.lower_m;
  task.place.retreat_m = params.retreat_m;
  task.attempt_time_s = shared.params.planning_time_s;
  task.cancelled = cancel_check(callbacks);
  return task;
}

Status Grasper::pick(const extperfc::PickGoal& goal, const MotionCallbacks& callbacks,
                     extperfc::PickResult& result) {
  const auto& shared = execution_.shared();
  if (!(goal.lift >= 0.0) || goal.lift > 1.0) return {ArmCode::kInvalidRequest, "lift must be from 0 to 1 m"};
  if (!(goal.planning_time >= 0.0)) return {ArmCode::kInvalidRequest, "planning_time must be 0 s or more"};
  callbacks.progress("choosing", 0.0);
  if (const auto not_ready = shared.robot_state.not_ready_reason()) return *not_ready;
  // From the choice until the object is grasped, the fingers may hide or push it.
  auto still = shared.scene.hold(goal.object);
  const auto task = pick_task(goal, callbacks);
  if (!task) return task.error();
  const auto world = shared.scene.world();
  if (!world) return world.error();
  const auto plan = arm::plan_pick(execution_.pipeline(), *task, *world);
  if (!plan) return reason_of(plan.error(), callbacks);
  still = shared.scene.hold(plan->object.name);
  result.object = plan->object.name;
  result.arm = plan->manipulator->name;
  result.grasps = static_cast<std::uint32_t>(plan->tried);
  const auto hand = std::find_if(hands_.begin(), hands_.end(),
                                 [&](const Hand& one) { return &one.manipulator == plan->manipulator; });
  return grasp(*hand, *plan, value_or_default(goal.planning_time, shared.params.planning_time_s), callbacks,
               result);
}

Status Grasper::grasp(Hand& hand, const arm::PickPlan& plan, double time_s, const MotionCallbacks& callbacks,
                      extperfc::PickResult& result) {
  const std::string& name = plan.object.name;
  hand.place.clear();
  if (plan.paths.place.size() > 0) hand.place = {plan.paths.place};
  if (auto opened = hand.gripper->open(callbacks); !opened) return opened.error();
  if (auto moved =
          move_joints(hand, plan.paths.approach.front(), time_s, with_stage(callbacks, "approaching", {}));
      failed(moved))
    return moved;
  const auto touch = [&](arm::CollisionWorld& world) {
    arm::allow_grasp(world, name, hand.manipulator.hand);
  };
  if (auto moved = move_along(hand, plan.paths.approach, time_s, with_stage(callbacks, "approaching", touch));
      failed(moved))
    return moved;
  callbacks.progress("grasping", 0.0);
  const auto tip = execution_.shared().transforms.root_T_frame(hand.tip(), ros::Time());
  if (!tip) return tip.error();
  result.grasp.header.frame_id = execution_.shared().arms.root_link();
  result.grasp.header.stamp = ros::Time::now();
  result.grasp.pose = ros_convert::to_message(*tip);
  const auto holds = hand.gripper->close(callbacks);
  if (!holds) return holds.error();
  if (!*holds) {
    (void)hand.gripper->open(callbacks);
    return {ArmCode::kGraspMissed, "the gripper closed without holding " + name};
  }
  return lift(hand, plan, time_s, callbacks);
}

Status Grasper::lift(Hand& hand, const arm::PickPlan& plan, double time_s, const MotionCallbacks& callbacks) {
  const auto& object = plan.object;
  if (auto done = change(SceneObject::ATTACH, object.name, &hand); failed(done)) return done;
  const auto rise = [&](arm::CollisionWorld& world) {
    arm::allow_support(world, object.name, object.shapes, object.root_T_object);
  };
  if (auto moved = move_along(hand, plan.paths.departure, time_s, with_stage(callbacks, "lifting", rise));
      failed(moved))
    return ended_from_outside(moved) ? moved : let_go(hand, object.name, moved);
  return still_holds(hand, object.name, callbacks);
}

/// Closing again shows whether the object is still held; it moves only empty fingers. An object that is not
/// leaves the scene, for where it lies is not known.
Status Grasper::still_holds(Hand& hand, const std::string& name, const MotionCallbacks& callbacks) {
  const auto holds = hand.gripper->close(callbacks);
  if (!holds) return holds.error();
  if (*holds) return success();
  (void)change(SceneObject::REMOVE, name, nullptr);
  return {ArmCode::kObjectLost, name + " slipped out of the " + hand.manipulator.name + " gripper"};
}

/// Opens the gripper where it is; the object stays in the scene at that place.
Status Grasper::let_go(Hand& hand, const std::string& name, const Status& why) {
  if (auto opened = hand.gripper->open({}); !opened)
    return {why.code, why.message + "; the gripper does not open: " + opened.error().message};
  if (auto done = change(SceneObject::DETACH, name, nullptr); failed(done))
    return {why.code, why.message + "; " + done.message};
  return {why.code, why.message + "; the gripper released the object"};
}

// Place.

Grasper::Maybe<Grasper::Hand*> Grasper::holding(const extperfc::PlaceGoal& goal, CollisionObject* item) {
  bool known = goal.arm.empty();
  for (auto& hand : hands_) {
    if (!goal.arm.empty() && hand.manipulator.name != goal.arm) continue;
    known = true;
    const auto held = execution_.shared().scene.held_by(hand.tip());
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
  const auto& shared = execution_.shared();
  const auto& params = shared.params;
  if (!(goal.retreat >= 0.0) || goal.retreat > 0.5)
    return {ArmCode::kInvalidRequest, "retreat must be from 0 to 0.5 m"};
  if (!(goal.planning_time >= 0.0)) return {ArmCode::kInvalidRequest, "planning_time must be 0 s or more"};
  callbacks.progress("choosing", 0.0);
  CollisionObject item;
  const auto found = holding(goal, &item);
  if (!found) return found.error();
  Hand& hand = **found;
  if (auto holds = still_holds(hand, item.name, callbacks); failed(holds)) return holds;
  const auto target = shared.transforms.root_T_pose(goal.pose);
  if (!target) return target.error();
  const auto carrying = shared.scene.world();
  if (!carrying) return carrying.error();
  auto positions = shared.robot_state.positions();
  if (!positions) return positions.error();
  arm::PlaceTask task;
  task.start = std::move(*positions);
  task.manipulator = &hand.manipulator;
  task.object = {item.name, hand.tip(), item.shapes, item.frame_T_object, item.touch_links};
  task.place = {{*target},
                goal.any_yaw != 0,
                params.grasp.lower_m,
                value_or_default(goal.retreat, params.grasp.retreat_m)};
  task.attempt_time_s = params.planning_time_s;
  task.starts = hand.place;
  task.cancelled = cancel_check(callbacks);
  const auto plan = arm::plan_place(execution_.pipeline(), task, *carrying);
  if (!plan) return reason_of(plan.error(), callbacks);
  auto status =
      put_down(hand, item, *plan, value_or_default(goal.planning_time, params.planning_time_s), callbacks);
  if (failed(status)) return status;
  result.placed.header.frame_id = shared.arms.root_link();
  result.placed.header.stamp = ros::Time::now();
  result.placed.pose = ros_convert::to_message(plan->candidate.root_T_object);
  return status;
}

Status Grasper::put_down(Hand& hand, const CollisionObject& item, const arm::PlacePlan& plan, double time_s,
                         const MotionCallbacks& callbacks) {
  const auto still = execution_.shared().scene.hold(item.name);  // until the fingers have left it
  const auto stand = [&](arm::CollisionWorld& world) {
    arm::allow_support(world, item.name, item.shapes, plan.candidate.root_T_object);
  };
  if (auto moved =
          move_joints(hand, plan.paths.approach.front(), time_s, with_stage(callbacks, "carrying", {}));
      failed(moved))
    return moved;
  if (auto moved = move_along(hand, plan.paths.approach, time_s, with_stage(callbacks, "lowering", stand));
      failed(moved))
    return moved;
  if (auto holds = still_holds(hand, item.name, callbacks); failed(holds)) return holds;
  callbacks.progress("releasing", 0.0);
  if (auto opened = hand.gripper->open(callbacks); !opened) return opened.error();
  if (auto done = change(SceneObject::DETACH, item.name, nullptr); failed(done)) return done;
  const auto touch = [&](arm::CollisionWorld& world) {
    arm::allow_grasp(world, item.name, hand.manipulator.hand);
  };
  if (auto moved = move_along(hand, plan.paths.departure, time_s, with_stage(callbacks, "retreating", touch));
      failed(moved) || !plan.clear)
    return moved;
  return left_behind(hand, item, callbacks);
}

/// Closing the empty gripper shows whether the object came along, stuck to a finger for example. The scene
/// then says so.
Status Grasper::left_behind(Hand& hand, const CollisionObject& item, const MotionCallbacks& callbacks) {
  callbacks.progress("checking", 0.0);
  const auto holds = hand.gripper->close(callbacks);
  if (!holds) return holds.error();
  if (!*holds) return success();
  SceneObject in_hand;
  in_hand.operation = SceneObject::MOVE;
  in_hand.name = item.name;
  in_hand.pose.header.frame_id = hand.tip();
  in_hand.pose.pose = ros_convert::to_message(item.frame_T_object);
  if (const auto moved = execution_.shared().scene.apply({in_hand}); !moved) return moved.error();
  if (auto done = change(SceneObject::ATTACH, item.name, &hand); failed(done)) return done;
  return {ArmCode::kNotReleased, item.name + " came along: it is still in the " + hand.manipulator.name +
                                     " gripper. Place it again, or take it out by hand."};
}

// Motions.

Grasper::Maybe<arm::MotionRequest> Grasper::request(const Hand& hand, double time_s) const {
  const auto positions = execution_.shared().robot_state.positions();
  if (!positions) return tl::unexpected(positions.error());
  const auto& params = execution_.shared().params;
  arm::MotionRequest request;
  request.group = hand.manipulator.group;
  request.start = *positions;
  request.planning_time_s = time_s;
  request.velocity_scale = params.velocity_scale;
  request.acceleration_scale = params.acceleration_scale;
  return request;
}

Status Grasper::move_joints(const Hand& hand, const JointVector& goal, double time_s,
                            const MotionCallbacks& callbacks) {
  auto asked = request(hand, time_s);
  if (!asked) return asked.error();
  arm::JointPositions positions;
  const auto& names = hand.manipulator.kinematics.chain().joint_names();
  for (std::size_t i = 0; i < names.size(); ++i) positions[names[i]] = goal[static_cast<Eigen::Index>(i)];
  asked->goal = std::move(positions);
  return execution_.move(std::move(*asked), 2, callbacks).status;
}

/// Close to objects, therefore slowly.
Status Grasper::move_along(const Hand& hand, const std::vector<JointVector>& path, double time_s,
                           const MotionCallbacks& callbacks) {
  auto asked = request(hand, time_s);
  if (!asked) return asked.error();
  asked->path = path;
  asked->velocity_scale *= execution_.shared().params.grasp.slow;
  return execution_.move(std::move(*asked), 0, callbacks).status;
}

Status Grasper::change(std::uint8_t operation, const std::string& name, const Hand* hand) {
  SceneObject message;
  message.operation = operation;
  message.name = name;
  if (hand != nullptr) {
    message.link = hand->tip();
    message.touch_links = hand->manipulator.hand.finger_links;
  }
  const auto done = execution_.shared().scene.apply({message});
  return done ? success() : done.error();
}

}  // namespace extperfc::ros_arm
