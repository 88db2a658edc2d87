#include "arm/planning/rrt_connect.hpp"

#include <utility>

namespace extperfc::arm {

namespace {

constexpr double kSameStateRad = 1e-9;

}  // namespace

RrtConnect::RrtConnect(CollisionChecker& checker, const JointLimits& limits, const PlannerParams& params,
                       JointSet moving, const JointVector& start, const std::vector<JointVector>& goals)
    : TwoTrees(params.max_states, start, goals),
      checker_(checker),
      limits_(limits),
      range_rad_(params.range_rad),
      moving_(std::move(moving)) {}

std::optional<JointVector> RrtConnect::sample(Rng& rng) {
  JointVector result = start();
  for (const int j : moving_) result[j] = rng.uniform(limits_.lower[j], limits_.upper[j]);
  return result;
}

RrtConnect::Step RrtConnect::extend(Tree& tree, int from, const JointVector& target,
                                    const std::function<bool()>& /*stop*/, int* added) {
  const JointVector& state = tree.state(from);
  const JointVector delta = target - state;
  const double length = delta.norm();
  const bool reaches = length <= range_rad_;
  const JointVector next = reaches ? target : JointVector(state + delta * (range_rad_ / length));
  if (length > kSameStateRad && !checker_.motion_free(state, next)) return Step::kBlocked;
  *added = tree.add(next, from);
  return reaches ? Step::kReached : Step::kAdvanced;
}

}  // namespace extperfc::arm
