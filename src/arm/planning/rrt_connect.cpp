#include "arm/planning/rrt_connect.hpp"

#include <algorithm>
#include <utility>

namespace extperfc::arm::planning {

namespace {

constexpr double kSameStateRad = 1e-9;
/// The tree that is ahead waits while it has more than this fraction of all states.
constexpr double kAhead = 0.66;

}  // namespace

RrtConnect::RrtConnect(CollisionChecker& checker, const JointLimits& limits, const PlannerParams& params,
                       JointSet moving, const JointVector& start, const std::vector<JointVector>& goals)
    : checker_(checker),
      limits_(limits),
      params_(params),
      moving_(std::move(moving)),
      from_start_(static_cast<int>(start.size())),
      from_goals_(static_cast<int>(start.size())) {
  from_start_.add(start, -1);
  for (const auto& goal : goals) from_goals_.add(goal, -1);
}

JointVector RrtConnect::sample(Rng& rng) const {
  JointVector result = from_start_.state(0);
  for (const int j : moving_) result[j] = rng.uniform(limits_.lower[j], limits_.upper[j]);
  return result;
}

RrtConnect::Step RrtConnect::extend(Tree& tree, int from, const JointVector& target, int* added) {
  const JointVector& state = tree.state(from);
  const JointVector delta = target - state;
  const double length = delta.norm();
  const bool reaches = length <= params_.range_rad;
  const JointVector next = reaches ? target : JointVector(state + delta * (params_.range_rad / length));
  if (length > kSameStateRad && !checker_.motion_free(state, next)) return Step::kBlocked;
  *added = tree.add(next, from);
  return reaches ? Step::kReached : Step::kAdvanced;
}

void RrtConnect::choose_tree() {
  const double fraction = static_cast<double>(from_start_.size()) / states();
  if (fraction > kAhead)
    grows_start_ = false;
  else if (fraction < 1.0 - kAhead)
    grows_start_ = true;
  else
    grows_start_ = !grows_start_;
}

Found RrtConnect::join(int grown, int other) const {
  const int in_start = grows_start_ ? grown : other;
  const int in_goals = grows_start_ ? other : grown;
  Found found;
  found.waypoints = from_start_.branch(in_start);
  auto back = from_goals_.branch(in_goals);
  std::reverse(back.begin(), back.end());
  found.waypoints.insert(found.waypoints.end(), back.begin() + 1, back.end());  // both hold the meeting state
  found.goal = in_goals;
  while (from_goals_.parent(found.goal) >= 0) found.goal = from_goals_.parent(found.goal);
  return found;
}

std::optional<Found> RrtConnect::grow(int samples, Rng& rng, const std::function<bool()>& stop) {
  for (int i = 0; i < samples && !full() && !stop(); ++i) {
    choose_tree();
    Tree& tree = grows_start_ ? from_start_ : from_goals_;
    Tree& other = grows_start_ ? from_goals_ : from_start_;
    const JointVector target = sample(rng);
    const auto nearest = tree.nearest(target);
    if (nearest.distance_rad > tree.domain_rad(nearest.index)) continue;
    int grown = -1;
    if (extend(tree, nearest.index, target, &grown) == Step::kBlocked) {
      tree.narrow_domain(nearest.index);
      continue;
    }
    tree.widen_domain(nearest.index);
    const JointVector meeting = tree.state(grown);
    int last = other.nearest(meeting).index;
    Step step = Step::kAdvanced;
    while (step == Step::kAdvanced && !full() && !stop()) step = extend(other, last, meeting, &last);
    if (step == Step::kReached) return join(grown, last);
  }
  return std::nullopt;
}

}  // namespace extperfc::arm::planning
