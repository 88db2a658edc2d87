#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/motion_planner.hpp"

#include "arm/planning/two_trees.hpp"

namespace extperfc::arm {

/// Indices of joints that move.
using JointSet = std::vector<int>;

/// Two trees with straight edges.
class RrtConnect : public TwoTrees {
 public:
  /// The start and all goals must be free and within the limits, and alike in the joints that are not in
  /// `moving`. The checker must outlive it.
  RrtConnect(CollisionChecker& checker, const JointLimits& limits, const PlannerParams& params,
             JointSet moving, const JointVector& start, const std::vector<JointVector>& goals);

 private:
  [[nodiscard]] std::optional<JointVector> sample(Rng& rng) override;
  Step extend(Tree& tree, int from, const JointVector& target, const std::function<bool()>& stop,
              int* added) override;

  CollisionChecker& checker_;
  JointLimits limits_;
  double range_rad_;
  JointSet moving_;
};

}  // namespace extperfc::arm
