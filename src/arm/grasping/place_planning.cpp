#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "extperfc/arm/pick_and_place.hpp"
#include "extperfc/world/shape_extent.hpp"

#include "arm/grasping/straight_path.hpp"

namespace extperfc::arm {
namespace {

/// The request; for a ball, which may rest in any orientation, also requests with approaches from vertical to
/// nearly horizontal.
std::vector<PlaceRequest> rotated_requests(const std::vector<Shape>& shapes, PlaceRequest request) {
  const bool ball = shapes.size() == 1 && std::holds_alternative<Sphere>(shapes.front().geometry) &&
                    shapes.front().body_T_shape.translation().norm() < 1e-6;
  if (!ball) return {request};
  request.any_yaw = true;
  std::vector<PlaceRequest> all{request};
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

/// Errors: those of place_poses().
Result<std::vector<PlaceCandidate>> place_candidates(const ParallelHand& hand,
                                                     const std::vector<Shape>& shapes,
                                                     const PlaceRequest& request, const PlaceParams& params) {
  std::vector<PlaceCandidate> all;
  std::optional<Error> first;
  for (const auto& rotated : rotated_requests(shapes, request)) {
    auto some = place_poses(hand, rotated, params);
    if (some)
      all.insert(all.end(), some->begin(), some->end());
    else if (!first)
      first = some.error();
  }
  if (all.empty()) return tl::unexpected(*first);
  return all;
}

class PlacePlanner {
 public:
  PlacePlanner(MotionPipeline& pipeline, const PlaceTask& task, const CollisionWorld& world)
      : pipeline_(pipeline),
        task_(task),
        world_(world),
        hand_(task.manipulator->hand),
        chain_(task.manipulator->kinematics.chain()) {}

  tl::expected<PlacePlan, Status> run() {
    Status last{ArmCode::kInvalidRequest, "no place is given"};
    for (const Pose& root_T_place : task_.place.root_T_places) {
      auto plan = plan_at(root_T_place);
      if (plan || plan.error().code == ArmCode::kCancelled) return plan;
      last = plan.error();
    }
    return tl::unexpected(last);
  }

 private:
  struct Attempt {
    double lower_m;
    double yaw_step_rad;
    bool padded;
    bool more_postures;
  };

  tl::expected<PlacePlan, Status> plan_at(const Pose& root_T_object) {
    PlaceRequest request;
    request.tip_T_object = task_.object.link_T_object;
    request.root_T_object = root_T_object;
    request.any_yaw = task_.place.any_yaw;
    request.opening_m = hand_.opening_max_m;
    request.support_z_m = vertical_extent(task_.object.shapes, root_T_object).low_m;
    const double lower_m = task_.place.lower_m;
    std::vector<Attempt> attempts{{lower_m, 0.3927, true, false}, {lower_m, 0.3927, false, false}};
    if (task_.thorough) {
      attempts.push_back({lower_m, 0.1963, false, true});
      attempts.push_back({shortened_m(lower_m), 0.1963, false, true});
    }
    Status last;
    for (const auto& attempt : attempts) {
      const auto candidates =
          place_candidates(hand_, task_.object.shapes, request,
                           {attempt.lower_m, task_.place.retreat_m, attempt.yaw_step_rad, 0.002});
      if (!candidates) return failure(ArmCode::kGoalUnreachable, candidates.error().message);
      auto plan = choose(*candidates, attempt);
      if (plan || plan.error().code != ArmCode::kGoalUnreachable) return plan;
      last = plan.error();
    }
    return tl::unexpected(last);
  }

  tl::expected<PlacePlan, Status> choose(const std::vector<PlaceCandidate>& candidates,
                                         const Attempt& attempt) {
    auto carrying = world_;
    allow_support(carrying, task_.object.name, task_.object.shapes, candidates.front().root_T_object);
    auto empty = world_;
    empty.remove(task_.object.name);
    const auto group = pipeline_.arms().group(task_.manipulator->group);
    if (!group) return failure(ArmCode::kInvalidRequest, group.error().message);
    const auto state = RobotArms::select(**group, task_.start);
    if (!state) return failure(ArmCode::kNoJointStates, state.error().message);
    auto full = pipeline_.checker((*group)->name, task_.start, carrying, attempt.padded);
    auto after = pipeline_.checker((*group)->name, task_.start, empty, attempt.padded);
    if (!full || !after) return failure(ArmCode::kInternal, (full ? after : full).error().message);
    // Down with the object (planned backwards, from below), back without it.
    const auto paths = [&](std::size_t index, const GraspCandidate& pose,
                           const JointVector& low) -> std::optional<StraightPaths> {
      auto down = straight_path(*full, chain_, low, pose.root_T_pregrasp);
      if (!down) return std::nullopt;
      auto back = straight_path(*after, chain_, low, candidates[index].root_T_retreat);
      if (!back) return std::nullopt;
      std::reverse(down->begin(), down->end());
      return StraightPaths{std::move(*down), std::move(*back), {}};
    };
    std::vector<GraspCandidate> poses(candidates.size());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      poses[i].root_T_pregrasp = candidates[i].root_T_above;
      poses[i].root_T_tip = candidates[i].root_T_tip;
      poses[i].score = 1.0;
    }
    auto chosen = choose_grasp(poses,
                               {{task_.manipulator->name, &task_.manipulator->kinematics, &*full, *state,
                                 nullptr, paths, task_.starts}},
                               options_of(attempt));
    if (task_.cancelled && task_.cancelled()) return failure(ArmCode::kCancelled, "cancelled");
    if (!chosen)
      return failure(ArmCode::kGoalUnreachable,
                     "cannot place " + task_.object.name + " there: " + chosen.error().message);
    const auto& candidate = candidates[static_cast<std::size_t>(chosen->candidate)];
    return PlacePlan{candidate, std::move(chosen->paths), clear_after(candidate)};
  }

  /// The tip's z points from the palm to the fingers' ends.
  [[nodiscard]] bool clear_after(const PlaceCandidate& candidate) const {
    const Pose tip_T_object = candidate.root_T_retreat.inverse() * candidate.root_T_object;
    const double object_m = vertical_extent(task_.object.shapes, tip_T_object).low_m;
    return std::all_of(hand_.parts.begin(), hand_.parts.end(),
                       [&](const FingerPart& part) { return part.z_high_m < object_m; });
  }

  [[nodiscard]] GraspChoiceOptions options_of(const Attempt& attempt) const {
    GraspChoiceOptions options;
    options.timeout_s = task_.attempt_time_s;
    options.cancelled = task_.cancelled;
    if (attempt.more_postures) {
      options.ik_restarts = 100;
      options.ik_timeout_s = 0.05;
      options.postures = 8;
    }
    return options;
  }

  MotionPipeline& pipeline_;
  const PlaceTask& task_;
  const CollisionWorld& world_;
  const ParallelHand& hand_;
  const ArmChain& chain_;
};

}  // namespace

tl::expected<PlacePlan, Status> plan_place(MotionPipeline& pipeline, const PlaceTask& task,
                                           const CollisionWorld& world) {
  return PlacePlanner(pipeline, task, world).run();
}

}  // namespace extperfc::arm
