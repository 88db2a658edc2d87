#include <algorithm>
#include <array>
#include <deque>
#include <optional>
#include <utility>

#include "extperfc/arm/pick_and_place.hpp"
#include "extperfc/world/shape_extent.hpp"

#include "arm/cartesian/arm_in_group.hpp"
#include "arm/grasping/straight_path.hpp"

namespace extperfc::arm {
namespace {

constexpr double kMinLift = 0.75;  ///< fraction of the wanted lift that is still accepted
constexpr int kMaxCandidates = 400;
constexpr double kPlaceTime_s = 0.3;  ///< short, because the place is planned for many grasps

/// Free distances that a grasp needs.
struct Clearances {
  double approach_m, lift_m, tilt_step_rad;
  bool padded;  ///< with the padding of plans, so that planning the same motion again succeeds
};

/// Grasps of an object by one manipulator, and what is needed to check them.
struct ManipulatorGrasps {
  const Manipulator* manipulator;
  std::vector<GraspCandidate> grasps;
  CollisionChecker checker;  ///< with open fingers, which may touch the object
  JointVector state;
};

class PickPlanner {
 public:
  PickPlanner(MotionPipeline& pipeline, const PickTask& task, const CollisionWorld& world)
      : pipeline_(pipeline), task_(task), world_(world) {}

  tl::expected<PickPlan, Status> run() {
    const auto& wanted = task_.grasp;
    const std::array<Clearances, 2> clearances_to_try{
        Clearances{wanted.approach_m, wanted.lift_m, wanted.tilt_step_rad, true},
        Clearances{shortened_m(wanted.approach_m), kMinLift * wanted.lift_m,
                   std::max(0.05, 0.5 * wanted.tilt_step_rad), false}};
    Status last{ArmCode::kNoGrasp, "no object to grasp"};
    for (const auto& clearances : clearances_to_try)
      for (const auto& object : task_.objects) {
        auto plan = choose(object, clearances);
        if (plan || plan.error().code != ArmCode::kNoGrasp) return plan;
        last = plan.error();
      }
    return tl::unexpected(last);
  }

 private:
  tl::expected<PickPlan, Status> choose(const WorldObject& object, const Clearances& clearances) {
    if (object.shapes.size() != 1)
      return failure(ArmCode::kNoGrasp, object.name + " has " + std::to_string(object.shapes.size()) +
                                            " shapes: only objects of one shape can be grasped");
    std::deque<ManipulatorGrasps> reachable;  // a deque keeps references valid
    std::string why;
    for (const Manipulator* manipulator : task_.manipulators) {
      auto grasps = grasps_of(*manipulator, object, clearances);
      if (grasps)
        reachable.push_back(std::move(*grasps));
      else if (grasps.error().code != ArmCode::kNoGrasp)
        return tl::unexpected(grasps.error());
      else
        why += (why.empty() ? "" : "; ") + manipulator->name + ": " + grasps.error().message;
    }
    if (reachable.empty()) return failure(ArmCode::kNoGrasp, object.name + ": " + why);
    std::vector<GraspArm> arms;
    arms.reserve(reachable.size());
    for (auto& one : reachable)
      arms.push_back({one.manipulator->name, &one.manipulator->kinematics, &one.checker, one.state,
                      &one.grasps, paths_of(object, one, clearances.lift_m)});
    GraspChoiceOptions options;
    options.timeout_s = task_.attempt_time_s;
    options.cancelled = task_.cancelled;
    auto chosen = choose_grasp({}, arms, options);
    if (task_.cancelled && task_.cancelled()) return failure(ArmCode::kCancelled, "cancelled");
    if (!chosen)
      return failure(
          ArmCode::kNoGrasp,
          object.name + ": " + chosen.error().message +
              (task_.place.root_T_places.empty() ? "" : "; the required place restricts the grasps"));
    const auto& best = reachable[static_cast<std::size_t>(chosen->arm)];
    return PickPlan{best.manipulator, object, best.grasps[static_cast<std::size_t>(chosen->candidate)],
                    std::move(chosen->paths), chosen->tried};
  }

  /// Errors: kNoGrasp where the shape does not fit the gripper; kNoJointStates; kInternal.
  tl::expected<ManipulatorGrasps, Status> grasps_of(const Manipulator& manipulator, const WorldObject& object,
                                                    const Clearances& clearances) {
    GraspObject target;
    target.geometry = object.shapes.front().geometry;
    target.root_T_object = object.root_T_object * object.shapes.front().body_T_shape;
    target.support_z_m = vertical_extent(target.geometry, target.root_T_object).low_m;
    auto params = task_.grasp;
    params.approach_m = clearances.approach_m;
    params.tilt_step_rad = clearances.tilt_step_rad;
    params.max_candidates = kMaxCandidates;
    auto grasps = generate_grasps(manipulator.hand, target, params);
    if (!grasps) return failure(ArmCode::kNoGrasp, grasps.error().message);
    const auto& robot = pipeline_.arms().robot();
    auto open = task_.start;
    const auto finger = robot.joint(manipulator.finger_joint);
    open[manipulator.finger_joint] = robot.joints()[static_cast<std::size_t>(*finger)].upper;
    auto world = world_;
    allow_grasp(world, object.name, manipulator.hand);
    auto checker = pipeline_.checker(manipulator.group, open, world, clearances.padded);
    if (!checker) return failure(ArmCode::kInternal, checker.error().message);
    const auto state = RobotArms::select(**pipeline_.arms().group(manipulator.group), open);
    if (!state) return failure(ArmCode::kNoJointStates, state.error().message);
    return ManipulatorGrasps{&manipulator, std::move(*grasps), std::move(*checker), *state};
  }

  /// The approach is planned backwards, from the grasp to the pregrasp. Keeps the references.
  StraightMotion paths_of(const WorldObject& object, ManipulatorGrasps& reachable, double lift_m) {
    struct Placing {
      std::size_t candidate;
      std::optional<JointVector> joints;
    };
    // A candidate is tried in several postures; whether the object can be placed does not depend on them.
    std::optional<Placing> last;
    return [this, &object, &reachable, lift_m, last](
               std::size_t index, const GraspCandidate& candidate,
               const JointVector& grasp) mutable -> std::optional<StraightPaths> {
      const bool known = last && last->candidate == index;
      if (known && !last->joints) return std::nullopt;
      const auto& chain = reachable.manipulator->kinematics.chain();
      auto approach = straight_path(reachable.checker, chain, grasp, candidate.root_T_pregrasp);
      if (!approach) return std::nullopt;
      std::reverse(approach->begin(), approach->end());
      const Pose root_T_tip = chain.forward(grasp);
      Pose lifted = root_T_tip;
      lifted.translation().z() += lift_m;
      auto lift = straight_path(reachable.checker, chain, grasp, lifted);
      if (!lift) return std::nullopt;
      StraightPaths paths{std::move(*approach), std::move(*lift), {}};
      if (task_.place.root_T_places.empty()) return paths;
      if (!known) last = Placing{index, placed(*reachable.manipulator, object, root_T_tip)};
      if (!last->joints) return std::nullopt;
      paths.place = *last->joints;
      return paths;
    };
  }

  /// Joint values with the object, grasped at this pose, at one of the required places.
  std::optional<JointVector> placed(const Manipulator& manipulator, const WorldObject& object,
                                    const Pose& root_T_tip) {
    const AttachedObject held{object.name, manipulator.hand.tip_link, object.shapes,
                              root_T_tip.inverse() * object.root_T_object, manipulator.hand.finger_links};
    auto carrying = world_;
    carrying.remove(object.name);
    if (const auto done = carrying.attach(held); !done) return std::nullopt;
    const auto plan = plan_place(
        pipeline_, {task_.start, &manipulator, held, task_.place, kPlaceTime_s, false, {}, task_.cancelled},
        carrying);
    if (!plan) return std::nullopt;
    return plan->paths.approach.back();
  }

  MotionPipeline& pipeline_;
  const PickTask& task_;
  const CollisionWorld& world_;
};

}  // namespace

Result<Manipulator> Manipulator::make(const RobotArms& arms, const std::string& name,
                                      const std::string& group, const std::string& tip_link,
                                      const std::string& finger_joint) {
  const auto known = arms.group(group);
  if (!known) return tl::unexpected(known.error());
  auto hand = hand_of(arms.robot(), tip_link, finger_joint);
  if (!hand) return tl::unexpected(hand.error());
  auto chain = ArmChain::make(arms.robot(), arms.root_link(), tip_link);
  if (!chain) return tl::unexpected(chain.error());
  if (const auto fits = ArmInGroup::make(*chain, (*known)->joints); !fits)
    return fail(fits.error().code, "group " + group + ": " + fits.error().message);
  return Manipulator{name, group, finger_joint, std::move(*hand), InverseKinematics(std::move(*chain))};
}

tl::expected<PickPlan, Status> plan_pick(MotionPipeline& pipeline, const PickTask& task,
                                         const CollisionWorld& world) {
  return PickPlanner(pipeline, task, world).run();
}

}  // namespace extperfc::arm
