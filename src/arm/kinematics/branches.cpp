#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "extperfc/arm/inverse_kinematics.hpp"

#include "arm/kinematics/check.hpp"
#include "arm/kinematics/enumeration.hpp"
#include "arm/kinematics/reach.hpp"
#include "arm/kinematics/self_motion.hpp"
#include "arm/kinematics/settle.hpp"

namespace extperfc::arm {
namespace {

using SetResult = tl::expected<IkSolutionSet, IkFailure>;

bool is_usable(const IkSearchOptions& options) {
  return ik::is_usable(options.tolerance) && options.timeout_s >= 0 && options.max_descents >= 1 &&
         options.patience >= 1 && options.max_branches >= 1 && options.step_rad > 0 &&
         std::isfinite(options.step_rad);
}

/// What `accept` refused.
struct Refused {
  int count{0};
  JointVector last;
};

/// Leaves what `accept` takes.
Refused filter(IkSolutionSet& set, const IkPredicate& accept) {
  Refused refused;
  for (IkBranch& branch : set.branches) {
    std::vector<JointVector> kept;
    for (const JointVector& joints : branch.joints) {
      if (accept(joints)) {
        kept.push_back(joints);
        continue;
      }
      ++refused.count;
      refused.last = joints;
    }
    branch.closed = branch.closed && kept.size() == branch.joints.size();
    branch.joints = std::move(kept);
  }
  auto& branches = set.branches;
  const auto is_empty = [](const IkBranch& branch) { return branch.joints.empty(); };
  branches.erase(std::remove_if(branches.begin(), branches.end(), is_empty), branches.end());
  return refused;
}

/// The failure's reason is that of solve().
SetResult nothing_found(const InverseKinematics& kinematics, const Pose& target, const JointVector& seed,
                        const IkSearchOptions& options) {
  constexpr int kRestarts = 10;  // nothing was found with many more
  IkOptions once;
  once.tolerance = options.tolerance;
  once.timeout_s = options.timeout_s;
  once.max_restarts = std::min(kRestarts, options.max_descents - 1);
  once.rng_seed = options.rng_seed;
  once.accept = options.accept;
  const auto result = kinematics.solve(target, seed, once);
  if (!result) return tl::unexpected(result.error());
  return IkSolutionSet{{IkBranch{{result->joints}, false}}, false};
}

SetResult search(const InverseKinematics& kinematics, const Pose& target, const JointVector& seed,
                 const IkSearchOptions& options) {
  const ArmChain& chain = kinematics.chain();
  if (!ik::is_rigid(target) || !ik::is_usable(chain, seed) || !is_usable(options))
    return tl::unexpected(ik::invalid_failure());
  if (ik::is_beyond(chain.geometry().reach, target, options.tolerance))
    return nothing_found(kinematics, target, seed, options);
  IkSolutionSet found = ik::Enumeration(chain, target, options).run(seed);
  if (found.branches.empty()) return nothing_found(kinematics, target, seed, options);
  if (!options.accept) return found;
  const Refused refused = filter(found, options.accept);
  if (!found.branches.empty()) return found;
  IkFailure failure;
  failure.reason = IkReason::kCollision;
  failure.closest = refused.last;
  failure.refused = refused.count;
  return tl::unexpected(failure);
}

struct Candidate {
  double distance;
  JointVector joints;
};

/// Nearest first.
std::vector<Candidate> by_distance(const ArmChain& chain, const IkSolutionSet& set, const JointVector& seed) {
  std::vector<Candidate> candidates;
  for (const IkBranch& branch : set.branches)
    for (const JointVector& joints : branch.joints) {
      const JointVector delta = chain.difference(joints, seed);
      candidates.push_back({delta.norm(), seed + delta});
    }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
  return candidates;
}

/// The nearest solution, found by settling the nearest candidates; a settled one that is refused does not
/// count.
IkSolution settle_nearest(const ArmChain& chain, const Pose& target, const std::vector<Candidate>& candidates,
                          const JointVector& seed, const IkSearchOptions& options) {
  constexpr double kSteps = 2;  // no candidate comes nearer by more of these
  const ik::Task task(target, options.tolerance, chain.geometry());
  const auto bounds = ik::bounds_of<Eigen::Dynamic>(chain);
  ik::Settle settle(chain.geometry(), task, bounds);
  const ik::Deadline deadline(options.timeout_s);
  Candidate best = candidates.front();
  for (const Candidate& candidate : candidates) {
    if (candidate.distance - kSteps * options.step_rad > best.distance || deadline.passed()) break;
    JointVector q = candidate.joints;
    settle.run(q, ik::near(seed), deadline);
    ik::unwind(bounds, seed, q);
    const double distance = (q - seed).norm();
    if (distance < best.distance && (!options.accept || options.accept(q))) best = {distance, q};
  }
  ik::AnyEvaluation at;
  at.compute(chain.geometry(), task, best.joints);
  return {best.joints, at.error.head<3>().norm(), at.error.tail<3>().norm(), 0};
}

}  // namespace

SetResult InverseKinematics::all_solutions(const Pose& target, const IkSearchOptions& options) const {
  return search(*this, target, chain_.mid_range(), options);
}

IkResult InverseKinematics::nearest_solution(const Pose& target, const JointVector& seed,
                                             const IkSearchOptions& options) const {
  const auto found = search(*this, target, seed, options);
  if (!found) return tl::unexpected(found.error());
  const auto candidates = by_distance(chain_, *found, seed);
  return settle_nearest(chain_, target, candidates, seed, options);
}

Result<IkBranch> InverseKinematics::sweep_redundancy(const JointVector& start,
                                                     const IkSweepOptions& options) const {
  if (!ik::is_usable(chain_, start) || !chain_.within_limits(start))
    return fail(ErrorCode::kInvalidArgument, "the start of a sweep must lie within the joint limits");
  if (!(options.step_rad > 0) || !std::isfinite(options.step_rad) || options.max_steps < 1)
    return fail(ErrorCode::kInvalidArgument, "a sweep needs a step above 0 and one step at least");
  IkTolerance held;
  for (int axis = 0; axis < 6; ++axis)
    if (options.free_axes[axis])
      (axis < 3 ? held.position_m : held.orientation_rad)[axis % 3] = std::numeric_limits<double>::infinity();
  const int redundancy = ik::SelfMotion::redundancy(chain_.joint_count(), held);
  if (redundancy != 1)
    return fail(ErrorCode::kUnsupported,
                "a sweep needs one degree of redundancy; there are " + std::to_string(redundancy));
  return ik::SelfMotion(chain_, start, held, options.step_rad).trace(options.max_steps);
}

}  // namespace extperfc::arm
