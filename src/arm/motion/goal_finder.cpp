#include "arm/motion/goal_finder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <utility>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/base/stopwatch.hpp"

#include "arm/collision/state_fault.hpp"

namespace extperfc::arm {

namespace {

std::string where(const ToolTarget& target) {
  const auto& p = target.root_T_tool.translation();
  char text[96];
  std::snprintf(text, sizeof text, "(%.3f, %.3f, %.3f) m in the robot's root frame", p.x(), p.y(), p.z());
  return text;
}

Status explain(const IkFailure& failure, const ArmInGroup& arm, const ToolTarget& target,
               const std::string& touching) {
  const std::string what = "no joint values bring " + arm.chain().tip_link() + " to " + where(target);
  switch (failure.reason) {
    case IkReason::kInvalid:
      return {ArmCode::kInvalidRequest,
              "the pose or its tolerance for " + arm.chain().tip_link() + " is not valid"};
    case IkReason::kOutOfReach: {
      char text[80];
      std::snprintf(text, sizeof text, ": out of reach by %.3f m and %.2f rad", failure.position_error_m,
                    failure.orientation_error_rad);
      return {ArmCode::kGoalUnreachable, what + text};
    }
    case IkReason::kLimits:
      return {ArmCode::kGoalUnreachable, what + " within the joint limits"};
    case IkReason::kCollision:
      return {ArmCode::kGoalInCollision, what + " without a collision" + touching};
    case IkReason::kTimeout:
      return {ArmCode::kPlanningTimeout, what + " within the time"};
  }
  return {ArmCode::kInternal, what};
}

/// One target and what was found for it: values of its chain.
struct Part {
  ArmInGroup arm;
  const ToolTarget* target;
  std::vector<JointVector> solutions;
};

/// Everything that the search for solutions of one arm needs to know.
class Finder {
 public:
  Finder(const JointVector& start, CollisionChecker& checker, const GoalSearch& search)
      : start_(start), checker_(checker), search_(search), rng_(search.seed) {}

  [[nodiscard]] bool cancelled() const { return search_.stop && search_.stop(); }
  [[nodiscard]] bool out_of_time() const { return watch_.seconds() > search_.time_s; }

  /// `alone`: nothing else moves, so a solution that collides is none.
  tl::expected<void, Status> solve(Part* part, bool alone) {
    const InverseKinematics solver(part->arm.chain());
    const JointVector from = part->arm.take(start_);
    for (int i = 0; i < search_.samples; ++i) {
      if (cancelled()) return failure(ArmCode::kCancelled, "cancelled");
      if (i > 0 && !part->solutions.empty() && out_of_time()) break;
      const auto found = solver.solve(part->target->root_T_tool, i == 0 ? from : anywhere(part->arm.chain()),
                                      options(*part, alone, i));
      if (found)
        add(part, found->joints);
      else if (i == 0)
        return tl::unexpected(
            explain(found.error(), part->arm, *part->target, touching(part->arm, found.error().closest)));
    }
    return {};
  }

 private:
  IkOptions options(const Part& part, bool alone, int round) {
    IkOptions options;
    options.tolerance = part.target->tolerance;
    options.timeout_s = round == 0 ? search_.time_s : 0.005;
    options.rng_seed = search_.seed + static_cast<std::uint64_t>(round);
    options.objective = round == 0 ? IkObjective::kNearSeed : IkObjective::kNone;
    if (alone)
      options.accept = [this, &part](const JointVector& joints) {
        return checker_.is_free(part.arm.put(joints, start_));
      };
    return options;
  }

  /// What blocks the solution that came last.
  std::string touching(const ArmInGroup& arm, const JointVector& joints) {
    if (joints.size() != arm.joint_count()) return {};
    const auto contact = checker_.contact(arm.put(joints, start_));
    return contact ? ": " + text_of(*contact) : std::string();
  }

  JointVector anywhere(const ArmChain& chain) {
    JointVector values(chain.joint_count());
    for (Eigen::Index i = 0; i < values.size(); ++i)
      values[i] =
          rng_.uniform(std::max(chain.limits().lower[i], -kPi), std::min(chain.limits().upper[i], kPi));
    return values;
  }

  static void add(Part* part, const JointVector& joints) {
    constexpr double kSame = 0.1;  // [rad]
    for (const auto& known : part->solutions)
      if ((known - joints).norm() < kSame) return;
    part->solutions.push_back(joints);
  }

  const JointVector& start_;
  CollisionChecker& checker_;
  const GoalSearch& search_;
  Rng rng_;
  Stopwatch watch_;
};

tl::expected<std::vector<Part>, Status> make_parts(const RobotArms& arms, const ArmGroup& group,
                                                   const std::vector<ToolTarget>& targets) {
  std::vector<Part> parts;
  std::set<int> used;
  for (const auto& target : targets) {
    auto arm = chain_to(arms, group, target.link);
    if (!arm) return tl::unexpected(arm.error());
    for (const auto joint : arm->places())
      if (!used.insert(joint).second)
        return failure(ArmCode::kInvalidRequest, "two goals need the same joints (" +
                                                     arm->chain().tip_link() +
                                                     "): several poses of one tool are for LINEAR motions");
    parts.push_back({std::move(*arm), &target, {}});
  }
  return parts;
}

/// All combinations of the parts' solutions, put into the start.
std::vector<JointVector> combine(const std::vector<Part>& parts, const JointVector& start) {
  std::vector<JointVector> all{start};
  for (const auto& part : parts) {
    std::vector<JointVector> next;
    for (const auto& base : all)
      for (const auto& solution : part.solutions) next.push_back(part.arm.put(solution, base));
    all = std::move(next);
  }
  return all;
}

}  // namespace

tl::expected<ArmInGroup, Status> chain_to(const RobotArms& arms, const ArmGroup& group,
                                          const std::string& link) {
  if (link.empty() && group.tips.size() != 1)
    return failure(ArmCode::kInvalidRequest, "group " + group.name + " has " +
                                                 std::to_string(group.tips.size()) +
                                                 " tips: name the link of the goal");
  const std::string& tip = link.empty() ? group.tips.front() : link;
  auto chain = ArmChain::make(arms.robot(), arms.root_link(), tip);
  if (!chain) return failure(ArmCode::kInvalidRequest, "the goal's link: " + chain.error().message);
  auto arm = ArmInGroup::make(*chain, group.joints);
  if (!arm) return failure(ArmCode::kInvalidRequest, "group " + group.name + ": " + arm.error().message);
  return *std::move(arm);
}

tl::expected<std::vector<JointVector>, Status> find_goals(const RobotArms& arms, const ArmGroup& group,
                                                          const std::vector<ToolTarget>& targets,
                                                          const JointVector& start, CollisionChecker& checker,
                                                          const GoalSearch& search) {
  if (targets.empty()) return failure(ArmCode::kInvalidRequest, "no goal was given");
  auto parts = make_parts(arms, group, targets);
  if (!parts) return tl::unexpected(parts.error());
  Finder finder(start, checker, search);
  for (auto& part : *parts)
    if (auto done = finder.solve(&part, search.collisions && parts->size() == 1); !done)
      return tl::unexpected(done.error());
  auto goals = combine(*parts, start);
  const auto nearer = [&](const JointVector& a, const JointVector& b) {
    return (a - start).squaredNorm() < (b - start).squaredNorm();
  };
  std::stable_sort(goals.begin(), goals.end(), nearer);
  std::vector<JointVector> free;
  for (const auto& goal : goals) {
    if (static_cast<int>(free.size()) == search.samples) break;
    if (!search.collisions || checker.is_free(goal)) free.push_back(goal);
  }
  if (!free.empty()) return free;
  const auto contact = checker.contact(goals.front());
  return failure(ArmCode::kGoalInCollision,
                 "every solution found for the goal collides" +
                     (contact ? ", the nearest: " + text_of(*contact) : std::string()));
}

}  // namespace extperfc::arm
