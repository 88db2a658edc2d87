#include "arm/planning/two_trees.hpp"

#include <algorithm>

namespace extperfc::arm {

namespace {

/// The tree that is ahead waits while it has more than this fraction of all nodes.
constexpr double kAhead = 0.66;

}  // namespace

TwoTrees::TwoTrees(int max_states, const JointVector& start, const std::vector<JointVector>& goals)
    : max_states_(max_states),
      from_start_(static_cast<int>(start.size())),
      from_goals_(static_cast<int>(start.size())) {
  from_start_.add(start, -1);
  for (const auto& goal : goals) from_goals_.add(goal, -1);
}

void TwoTrees::choose_tree() {
  const double fraction =
      static_cast<double>(from_start_.size()) / static_cast<double>(from_start_.size() + from_goals_.size());
  if (fraction > kAhead)
    grows_start_ = false;
  else if (fraction < 1.0 - kAhead)
    grows_start_ = true;
  else
    grows_start_ = !grows_start_;
}

Found TwoTrees::join(int grown, int other) const {
  const int in_start = grows_start_ ? grown : other;
  const int in_goals = grows_start_ ? other : grown;
  Found found;
  found.waypoints = from_start_.branch(in_start);
  const auto back = from_goals_.branch(in_goals);
  found.waypoints.insert(found.waypoints.end(), back.rbegin() + 1, back.rend());  // both hold the last state
  found.goal = in_goals;
  while (from_goals_.parent(found.goal) >= 0) found.goal = from_goals_.parent(found.goal);
  return found;
}

std::optional<Found> TwoTrees::grow(int samples, Rng& rng, const std::function<bool()>& stop) {
  for (int i = 0; i < samples && !full() && !stop(); ++i) {
    choose_tree();
    Tree& tree = grows_start_ ? from_start_ : from_goals_;
    Tree& other = grows_start_ ? from_goals_ : from_start_;
    const auto target = sample(rng);
    if (!target) continue;
    const auto nearest = tree.nearest(*target);
    if (nearest.distance_rad > tree.domain_rad(nearest.index)) continue;
    int grown = -1;
    if (extend(tree, nearest.index, *target, stop, &grown) == Step::kBlocked) {
      tree.narrow_domain(nearest.index);
      continue;
    }
    tree.widen_domain(nearest.index);
    const JointVector meeting = tree.state(grown);
    int last = other.nearest(meeting).index;
    Step step = Step::kAdvanced;
    while (step == Step::kAdvanced && !full() && !stop()) step = extend(other, last, meeting, stop, &last);
    if (step == Step::kReached) return join(grown, last);
  }
  return std::nullopt;
}

}  // namespace extperfc::arm
