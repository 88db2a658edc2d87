#pragma once

#include <functional>
#include <optional>

#include "arm/constrained/manifold.hpp"
#include "arm/planning/two_trees.hpp"

namespace extperfc::arm {

/// Two trees on a manifold.
class Cbirrt : public TwoTrees {
 public:
  /// The start and all goals must be free, within the limits and on the manifold, which must outlive it.
  Cbirrt(Manifold& manifold, double range_rad, int max_states, const JointVector& start, const States& goals)
      : TwoTrees(max_states, start, goals), manifold_(manifold), range_rad_(range_rad) {}

 private:
  [[nodiscard]] std::optional<JointVector> sample(Rng& rng) override { return manifold_.sample(rng); }
  Step extend(Tree& tree, int from, const JointVector& target, const std::function<bool()>& stop,
              int* added) override;

  Manifold& manifold_;
  double range_rad_;
};

}  // namespace extperfc::arm
