#include "arm/motion/goal_finder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <utility>

#include "extperfc/base/rng.hpp"
#include "extperfc/base/stopwatch.hpp"

namespace extperfc::arm::motion {

namespace {

std::string where(const ToolTarget& target) {
  const auto& p = target.root_T_tool.translation();
  char text[96];
  std::snprintf(text, sizeof text, "(%.3f, %.3f, %.3f) m in the robot's root frame", p.x(), p.y(), p.z());
  return text;
}

Status explain(const IkFailure& failure, const GroupChain& arm, const ToolTarget& target,
               const std::string& touching) {
  const std::string what = "no joint values bring " + arm.chain.tip_link() + " to " + where(target);
  switch (failure.reason) {
    case IkReason::kInvalid:
      return {ArmCode::kInvalidRequest,
              "the pose or its tolerance for " + arm.chain.tip_link() + " is not valid"};
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
  GroupChain arm;
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
    const InverseKinematics solver(part->arm.chain);
    const JointVector from = part->arm.take(start_);
    for (int i = 0; i < search_.samples; ++i) {
      if (cancelled()) return failure(ArmCode::kCancelled, "cancelled");
      if (i > 0 && !part->solutions.empty() && out_of_time()) break;
      const auto found = solver.solve(part->target->root_T_tool, i == 0 ? from : anywhere(part->arm.chain),
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
        JointVector all = start_;
        part.arm.put(joints, &all);
        return checker_.is_free(all);
      };
    return options;
  }

  /// What blocks the solution that came last.
  std::string touching(const GroupChain& arm, const JointVector& joints) {
    if (joints.size() != static_cast<Eigen::Index>(arm.in_group.size())) return {};
    JointVector all = start_;
    arm.put(joints, &all);
    const auto contact = checker_.contact(all);
    return contact ? ": " + contact->first + " touches " + contact->second : std::string();
  }

  JointVector anywhere(const ArmChain& chain) {
    JointVector values(chain.joint_count());
    for (Eigen::Index i = 0; i < values.size(); ++i)
      values[i] =
          rng_.uniform(std::max(chain.limits().lower[i], -M_PI), std::min(chain.limits().upper[i], M_PI));
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
  std::set<Eigen::Index> used;
  for (const auto& target : targets) {
    auto arm = chain_to(arms, group, target.link);
    if (!arm) return tl::unexpected(arm.error());
    for (const auto joint : arm->in_group)
      if (!used.insert(joint).second)
        return failure(ArmCode::kInvalidRequest, "two goals need the same joints (" + arm->chain.tip_link() +
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
      for (const auto& solution : part.solutions) {
        next.push_back(base);
        part.arm.put(solution, &next.back());
      }
    all = std::move(next);
  }
  return all;
}

}  // namespace

JointVector GroupChain::take(const JointVector& group_values) const {
  JointVector values(static_cast<Eigen::Index>(in_group.size()));
  for (std::size_t i = 0; i < in_group.size(); ++i)
    values[static_cast<Eigen::Index>(i)] = group_values[in_group[i]];
  return values;
}

void GroupChain::put(const JointVector& chain_values, JointVector* group_values) const {
  for (std::size_t i = 0; i < in_group.size(); ++i)
    (*group_values)[in_group[i]] = chain_values[static_cast<Eigen::Index>(i)];
}

tl::expected<GroupChain, Status> chain_to(const RobotArms& arms, const ArmGroup& group,
                                          const std::string& link) {
  if (link.empty() && group.tips.size() != 1)
    return failure(ArmCode::kInvalidRequest, "group " + group.name + " has " +
                                                 std::to_string(group.tips.size()) +
                                                 " tips: name the link of the goal");
  const std::string& tip = link.empty() ? group.tips.front() : link;
  auto chain = ArmChain::make(arms.robot(), arms.root_link(), tip);
  if (!chain) return failure(ArmCode::kInvalidRequest, "the goal's link: " + chain.error().message);
  const auto foreign = [&](const std::string& joint) {
    return "link " + tip + " is moved by " + joint + ", which is not in the group " + group.name;
  };
  std::vector<Eigen::Index> in_group;
  for (const auto& joint : chain->joint_names()) {
    const auto found = std::find(group.joints.begin(), group.joints.end(), joint);
    if (found == group.joints.end()) return failure(ArmCode::kInvalidRequest, foreign(joint));
    in_group.push_back(found - group.joints.begin());
  }
  return GroupChain{std::move(*chain), std::move(in_group)};
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
  return failure(
      ArmCode::kGoalInCollision,
      "every solution found for the goal collides" +
          (contact ? ", the nearest: " + contact->first + " touches " + contact->second : std::string()));
}

}  // namespace extperfc::arm::motion
