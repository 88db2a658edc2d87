#include "arm/constrained/cbirrt.hpp"

#include <utility>

namespace extperfc::arm {

Cbirrt::Step Cbirrt::extend(Tree& tree, int from, const JointVector& target,
                            const std::function<bool()>& stop, int* added) {
  const JointVector state = tree.state(from);
  if (target == state) {
    *added = from;
    return Step::kReached;
  }
  const auto walk = manifold_.walk(state, target, range_rad_, stop);
  States pieces;
  const std::size_t proven = manifold_.prove(state, walk.states, &pieces, stop);
  if (walk.states.empty() || proven < walk.states.size()) return Step::kBlocked;
  const JointVector end = pieces.back();
  pieces.pop_back();
  *added = tree.add(end, from, std::move(pieces));
  return walk.reached ? Step::kReached : Step::kAdvanced;
}

}  // namespace extperfc::arm
