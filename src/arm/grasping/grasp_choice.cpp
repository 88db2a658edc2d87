#include "extperfc/arm/grasp_choice.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "extperfc/base/stopwatch.hpp"
#include "extperfc/world/shape_extent.hpp"

#include "arm/collision/state_fault.hpp"

namespace extperfc::arm {
namespace {

constexpr double kStep = 0.01;  // [m] between places on a straight path
constexpr double kMaxRotation =
    0.2;  // [rad] of a joint between two of them: more is a jump to another branch
constexpr double kSupportSlack = 0.01;  // [m] an object's support ends at most this far above its bottom
constexpr double kTight = 0.003;        // [m] a gripper with less to spare may touch what it shall enclose

/// One arm among all joints of its checker.
class ReachableGrasps {
 public:
  ReachableGrasps(const GraspArm& arm, const GraspChoiceOptions& options) : arm_(arm), options_(options) {
    if (arm.kinematics == nullptr || arm.checker == nullptr)
      throw std::invalid_argument("arm " + arm.name + " lacks kinematics or a collision checker");
    const auto& names = arm.checker->model().joint_names();
    if (arm.state.size() != static_cast<Eigen::Index>(names.size()))
      throw std::invalid_argument("arm " + arm.name +
                                  ": the state has another size than the checker's joints");
    for (const auto& name : arm.kinematics->chain().joint_names()) {
      const auto found = std::find(names.begin(), names.end(), name);
      if (found == names.end())
        throw std::invalid_argument("arm " + arm.name + ": the checker does not move joint " + name);
      joints_.push_back(static_cast<int>(found - names.begin()));
    }
    seed_.resize(static_cast<Eigen::Index>(joints_.size()));
    for (Eigen::Index i = 0; i < seed_.size(); ++i) seed_[i] = arm.state[joints_[i]];
    for (const JointVector& start : arm.starts)
      if (start.size() != seed_.size())
        throw std::invalid_argument("arm " + arm.name + ": a start has another size than the arm's joints");
  }

  struct Found {
    StraightPaths paths;
    double effort{0};  ///< largest displacement of a joint from where the arm is
  };

  [[nodiscard]] tl::expected<Found, GraspRefusal> reach(std::size_t index, const GraspCandidate& candidate) {
    for (const JointVector& start : arm_.starts)
      if (const auto grasp = solve(candidate.root_T_tip, start, 0))
        if (auto found = with_paths(index, candidate, grasp->joints)) return std::move(*found);
    GraspRefusal last = GraspRefusal::kOutOfReach;
    for (int posture = 0; posture < options_.postures; ++posture) {
      if (posture > 0 && options_.cancelled && options_.cancelled()) break;
      const auto grasp = solve(candidate.root_T_tip, start(posture), posture);
      if (!grasp) {
        if (posture == 0) return tl::unexpected<GraspRefusal>(refused(grasp.error()));
        break;
      }
      last = GraspRefusal::kNoPath;
      if (auto found = with_paths(index, candidate, grasp->joints)) return std::move(*found);
    }
    return tl::unexpected<GraspRefusal>(last);
  }

  /// What touched what in the last posture that was refused; empty when none was.
  [[nodiscard]] std::string touching() const {
    if (in_collision_.size() == 0) return {};
    const auto contact = arm_.checker->contact(whole(in_collision_));
    return contact ? " (last: " + text_of(*contact) + ")" : std::string();
  }

 private:
  [[nodiscard]] GraspRefusal refused(const IkFailure& failure) {
    if (failure.reason == IkReason::kCollision) in_collision_ = failure.closest;
    return refusal(failure.reason);
  }

  /// The straight paths of these joint values, when they are free.
  [[nodiscard]] std::optional<Found> with_paths(std::size_t index, const GraspCandidate& candidate,
                                                const JointVector& grasp) const {
    auto paths = arm_.straight ? arm_.straight(index, candidate, grasp) : approach(candidate, grasp);
    if (!paths || paths->approach.empty()) return std::nullopt;
    const double effort =
        arm_.kinematics->chain().difference(paths->approach.front(), seed_).cwiseAbs().maxCoeff();
    return Found{std::move(*paths), effort};
  }

  [[nodiscard]] JointVector whole(const JointVector& joints) const {
    JointVector state = arm_.state;
    for (Eigen::Index i = 0; i < joints.size(); ++i) state[joints_[i]] = joints[i];
    return state;
  }

  /// Where the solver starts: where the arm is, then mid-range, then random.
  [[nodiscard]] JointVector start(int posture) const {
    return posture == 0 ? seed_ : arm_.kinematics->chain().mid_range();
  }

  [[nodiscard]] IkResult solve(const Pose& root_T_tip, const JointVector& seed, int posture) const {
    IkOptions options;
    options.timeout_s = options_.ik_timeout_s;
    options.max_restarts = options_.ik_restarts;
    options.rng_seed = 1 + static_cast<std::uint64_t>(posture);
    if (posture == 0) options.objective = IkObjective::kNearSeed;
    options.accept = [this](const JointVector& joints) { return arm_.checker->is_free(whole(joints)); };
    JointVector from = seed;
    if (posture > 1) from = arm_.kinematics->chain().clamp(JointVector(seed + offset(posture)));
    return arm_.kinematics->solve(root_T_tip, from, options);
  }

  /// Deterministic, different for every posture: spreads the starts about mid-range.
  [[nodiscard]] JointVector offset(int posture) const {
    JointVector direction(seed_.size());
    for (Eigen::Index i = 0; i < direction.size(); ++i)
      direction[i] = std::sin(12.9898 * posture + 78.233 * static_cast<double>(i));
    return direction;
  }

  [[nodiscard]] static GraspRefusal refusal(IkReason reason) {
    switch (reason) {
      case IkReason::kLimits:
        return GraspRefusal::kLimits;
      case IkReason::kCollision:
        return GraspRefusal::kCollision;
      case IkReason::kTimeout:
        return GraspRefusal::kTimeout;
      case IkReason::kInvalid:
      case IkReason::kOutOfReach:
        break;
    }
    return GraspRefusal::kOutOfReach;
  }

  /// Followed backwards, from the grasp to the pregrasp.
  [[nodiscard]] std::optional<StraightPaths> approach(const GraspCandidate& candidate,
                                                      const JointVector& grasp) const {
    const InverseKinematics& kinematics = *arm_.kinematics;
    const Pose start = kinematics.chain().forward(grasp);
    const Pose& pregrasp = candidate.root_T_pregrasp;
    const Eigen::Vector3d delta = pregrasp.translation() - start.translation();
    const Eigen::Quaterniond rotation_from(start.linear()), rotation_to(pregrasp.linear());
    const int steps = std::max(1, static_cast<int>(std::ceil(delta.norm() / kStep)));
    std::vector<JointVector> points{grasp};
    for (int i = 1; i <= steps; ++i) {
      const double fraction = static_cast<double>(i) / steps;
      Pose target = Pose::Identity();
      target.translation() = start.translation() + fraction * delta;
      target.linear() = rotation_from.slerp(fraction, rotation_to).toRotationMatrix();
      IkOptions options;
      options.timeout_s = options_.ik_timeout_s;
      options.max_restarts = 0;
      options.objective = IkObjective::kNearSeed;
      const auto next = kinematics.solve(target, points.back(), options);
      if (!next || (next->joints - points.back()).cwiseAbs().maxCoeff() > kMaxRotation) return std::nullopt;
      if (!arm_.checker->motion_free(whole(points.back()), whole(next->joints))) return std::nullopt;
      points.push_back(next->joints);
    }
    std::reverse(points.begin(), points.end());
    return StraightPaths{std::move(points), {}, {}};
  }

  const GraspArm& arm_;
  const GraspChoiceOptions& options_;
  std::vector<int> joints_;  ///< of the arm, among the checker's
  JointVector seed_;
  JointVector in_collision_;
};

std::string summary(const std::vector<GraspArm>& arms, const std::vector<ReachableGrasps>& reachable,
                    const NoGrasp& failure, std::size_t candidates) {
  std::string text = "none of " + std::to_string(failure.tried) + " grasps can be reached";
  if (failure.timed_out) text += " (the time was up, " + std::to_string(candidates) + " there are)";
  for (std::size_t i = 0; i < arms.size(); ++i) {
    text += "; " + arms[i].name + ":";
    bool any = false;
    for (int k = 0; k < kGraspRefusals; ++k) {
      if (failure.refusals[i][k] == 0) continue;
      text += std::string(any ? ", " : " ") + std::to_string(failure.refusals[i][k]) + " " +
              to_string(static_cast<GraspRefusal>(k));
      any = true;
    }
    text += any ? reachable[i].touching() : " not tried";
  }
  return text;
}

}  // namespace

const char* to_string(GraspRefusal refusal) {
  switch (refusal) {
    case GraspRefusal::kOutOfReach:
      return "out of reach";
    case GraspRefusal::kLimits:
      return "beyond the joints' limits";
    case GraspRefusal::kCollision:
      return "in collision";
    case GraspRefusal::kTimeout:
      return "not solved in time";
    case GraspRefusal::kNoPath:
      return "without a straight collision-free path";
  }
  return "?";
}

tl::expected<GraspChoice, NoGrasp> choose_grasp(const std::vector<GraspCandidate>& candidates,
                                                const std::vector<GraspArm>& arms,
                                                const GraspChoiceOptions& options) {
  if (arms.empty()) throw std::invalid_argument("no arm to grasp with");
  std::vector<ReachableGrasps> reachable;
  reachable.reserve(arms.size());
  for (const GraspArm& arm : arms) reachable.emplace_back(arm, options);
  NoGrasp failure;
  failure.refusals.resize(arms.size());
  const Stopwatch watch;
  std::vector<const std::vector<GraspCandidate>*> lists;
  std::size_t ranks = 0;
  for (const GraspArm& arm : arms) {
    lists.push_back(arm.grasps != nullptr ? arm.grasps : &candidates);
    ranks = std::max(ranks, lists.back()->size());
  }
  for (std::size_t rank = 0; rank < ranks; ++rank) {
    if (watch.seconds() > options.timeout_s || (options.cancelled && options.cancelled())) {
      failure.timed_out = true;
      break;
    }
    ++failure.tried;
    std::optional<ReachableGrasps::Found> best;
    int arm = -1;
    bool best_is_tight = false;
    for (std::size_t i = 0; i < reachable.size(); ++i) {
      if (rank >= lists[i]->size()) continue;
      const GraspCandidate& candidate = (*lists[i])[rank];
      const bool is_tight = candidate.spare_m < kTight;
      auto found = reachable[i].reach(rank, candidate);
      if (!found) {
        ++failure.refusals[i][static_cast<int>(found.error())];
      } else if (!best || std::pair(is_tight, found->effort) < std::pair(best_is_tight, best->effort)) {
        best = std::move(*found);
        best_is_tight = is_tight;
        arm = static_cast<int>(i);
      }
    }
    if (best) return GraspChoice{arm, static_cast<int>(rank), std::move(best->paths), failure.tried};
  }
  failure.message = summary(arms, reachable, failure, ranks);
  return tl::unexpected<NoGrasp>(std::move(failure));
}

void allow_grasp(CollisionWorld& world, const std::string& object, const ParallelHand& hand) {
  for (const std::string& link : hand.finger_links) world.allow(object, link);
}

void allow_support(CollisionWorld& world, const std::string& object, const std::vector<Shape>& shapes,
                   const Pose& root_T_object) {
  const double bottom_m = vertical_extent(shapes, root_T_object).low_m;
  std::vector<std::string> below;
  for (const auto& [name, placed] : world.objects())
    if (name != object && vertical_extent(placed->object.shapes, placed->object.root_T_object).high_m <=
                              bottom_m + kSupportSlack)
      below.push_back(name);
  for (const auto& name : below) world.allow(object, name);
}

}  // namespace extperfc::arm
