#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "arm/planning/rrt_connect.hpp"

namespace extperfc::arm::planning {

/// Joints by the branches of the robot's tree, e.g. left arm and right arm, in the order of their first
/// joints.
[[nodiscard]] std::vector<JointSet> branches(const CollisionModel& model);

/// A path by the cheapest means that finds one. First straight. Then, where several branches move, branch
/// after branch while the others stand (prioritised planning: Erdmann and Lozano-Perez, "On multiple moving
/// objects", Algorithmica 1987), in one order and in the other; it searches 7 joints at a time instead of 14.
/// Then all joints at once, which finds every way that there is. The last two take turns, with twice the
/// samples each time.
class Search {
 public:
  /// The checker must outlive it.
  Search(CollisionChecker& checker, const JointLimits& limits, const PlannerParams& params);

  /// The start and all goals must be free and within the limits. Ends without a path when `stop` says so or
  /// the trees are full.
  [[nodiscard]] std::optional<Found> run(const JointVector& start, const std::vector<JointVector>& goals,
                                         const std::function<bool()>& stop);
  /// In the trees of all searches.
  [[nodiscard]] int states() const { return states_; }

 private:
  std::optional<Found> straight(const JointVector& start, const std::vector<JointVector>& goals);
  std::optional<Found> branch_after_branch(const JointVector& start, const JointVector& goal,
                                           const std::vector<JointSet>& order, int samples,
                                           const std::function<bool()>& stop);

  CollisionChecker& checker_;
  JointLimits limits_;
  PlannerParams params_;
  std::vector<JointSet> branches_;
  Rng rng_;
  int states_{0};
};

}  // namespace extperfc::arm::planning
