#include "arm/constrained/cbirrt.hpp"

#include <algorithm>
#include <utility>

namespace extperfc::arm::constrained {

namespace {

/// The tree that is ahead waits while it has more than this fraction of all nodes.
constexpr double kAhead = 0.66;

/// States from the root of `index` to `index`, those within edges included.
template <typename Side>
States branch(const Side& side, int index) {
  std::vector<int> nodes;
  for (; index >= 0; index = side.tree.parent(index)) nodes.push_back(index);
  States result;
  for (auto node = nodes.rbegin(); node != nodes.rend(); ++node)
    result.insert(result.end(), side.edges[*node].begin(), side.edges[*node].end());
  return result;
}

}  // namespace

Cbirrt::Cbirrt(Manifold& manifold, double range_rad, int max_states, const JointVector& start,
               const States& goals)
    : manifold_(manifold),
      range_rad_(range_rad),
      max_states_(max_states),
      from_start_(static_cast<int>(start.size())),
      from_goals_(static_cast<int>(start.size())) {
  add_root(&from_start_, start);
  for (const auto& goal : goals) add_root(&from_goals_, goal);
}

void Cbirrt::add_root(Side* side, const JointVector& state) {
  side->tree.add(state, -1);
  side->edges.push_back({state});
  ++states_;
}

Cbirrt::Step Cbirrt::extend(Side* side, int from, const JointVector& target,
                            const std::function<bool()>& stop, int* added) {
  const JointVector state = side->tree.state(from);
  if (target == state) {
    *added = from;
    return Step::kReached;
  }
  const auto walk = manifold_.walk(state, target, range_rad_, stop);
  States pieces;
  const std::size_t proven = manifold_.prove(state, walk.states, &pieces, stop);
  if (walk.states.empty() || proven < walk.states.size()) return Step::kBlocked;
  *added = side->tree.add(pieces.back(), from);
  states_ += static_cast<int>(pieces.size());
  side->edges.push_back(std::move(pieces));
  return walk.reached ? Step::kReached : Step::kAdvanced;
}

Found Cbirrt::join(int in_start, int in_goals) const {
  Found found;
  found.waypoints = branch(from_start_, in_start);
  States back = branch(from_goals_, in_goals);
  std::reverse(back.begin(), back.end());
  found.waypoints.insert(found.waypoints.end(), back.begin() + 1, back.end());  // both hold the meeting state
  found.goal = in_goals;
  while (from_goals_.tree.parent(found.goal) >= 0) found.goal = from_goals_.tree.parent(found.goal);
  return found;
}

std::optional<Found> Cbirrt::grow(Rng& rng, const std::function<bool()>& stop) {
  while (!full() && !stop()) {
    const double fraction = static_cast<double>(from_start_.tree.size()) /
                            static_cast<double>(from_start_.tree.size() + from_goals_.tree.size());
    grows_start_ = fraction > kAhead ? false : fraction < 1.0 - kAhead ? true : !grows_start_;
    Side& side = grows_start_ ? from_start_ : from_goals_;
    Side& other = grows_start_ ? from_goals_ : from_start_;
    const auto target = manifold_.sample(rng);
    if (!target) continue;
    const auto nearest = side.tree.nearest(*target);
    if (nearest.distance_rad > side.tree.domain_rad(nearest.index)) continue;
    int grown = -1;
    if (extend(&side, nearest.index, *target, stop, &grown) == Step::kBlocked) {
      side.tree.narrow_domain(nearest.index);
      continue;
    }
    side.tree.widen_domain(nearest.index);
    const JointVector meeting = side.tree.state(grown);
    int last = other.tree.nearest(meeting).index;
    Step step = Step::kAdvanced;
    while (step == Step::kAdvanced && !full() && !stop()) step = extend(&other, last, meeting, stop, &last);
    if (step == Step::kReached) return grows_start_ ? join(grown, last) : join(last, grown);
  }
  return std::nullopt;
}

}  // namespace extperfc::arm::constrained
