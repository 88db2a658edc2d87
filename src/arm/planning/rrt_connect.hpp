#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/motion_planner.hpp"
#include "extperfc/base/rng.hpp"

#include "arm/planning/tree.hpp"

namespace extperfc::arm::planning {

/// A path and the index of the goal at its end.
struct Found {
  std::vector<JointVector> waypoints;
  int goal{-1};
};

/// Indices of joints that move.
using JointSet = std::vector<int>;

/// Two trees that grow towards each other, one from the start and one from all goals.
class RrtConnect {
 public:
  /// The start and all goals must be free and within the limits, and alike in the joints that are not in
  /// `moving`. The checker must outlive it.
  RrtConnect(CollisionChecker& checker, const JointLimits& limits, const PlannerParams& params,
             JointSet moving, const JointVector& start, const std::vector<JointVector>& goals);

  /// Draws at most `samples` samples; nothing when the trees did not meet, `stop` said so, or the trees are
  /// full. Goes on where the last call ended.
  [[nodiscard]] std::optional<Found> grow(int samples, Rng& rng, const std::function<bool()>& stop);

  [[nodiscard]] int states() const { return from_start_.size() + from_goals_.size(); }
  [[nodiscard]] bool full() const { return states() >= params_.max_states; }

 private:
  enum class Step { kBlocked, kAdvanced, kReached };

  void choose_tree();
  [[nodiscard]] JointVector sample(Rng& rng) const;
  Step extend(Tree& tree, int from, const JointVector& target, int* added);
  [[nodiscard]] Found join(int grown, int other) const;

  CollisionChecker& checker_;
  JointLimits limits_;
  PlannerParams params_;
  JointSet moving_;
  Tree from_start_, from_goals_;
  bool grows_start_{true};
};

}  // namespace extperfc::arm::planning
