#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "arm/planning/rrt_connect.hpp"

namespace extperfc::arm {

/// Joints by the branches of the robot's tree, e.g. left arm and right arm, in the order of their first
/// joints.
[[nodiscard]] std::vector<JointSet> branches(const CollisionModel& model);

/// A path by the cheapest means that finds one. First straight. Then, where several branches move, branch
/// after branch while the others stand (prioritised planning: Erdmann and Lozano-Perez, "On multiple moving
/// objects", Algorithmica 1987), in one order and in the other; it searches 7 joints at a time instead of 14.
/// Then all joints at once, which finds every path that exists. The last two alternate, with twice the
/// samples each time.
class Search {
 public:
  /// The checker must outlive it. `first_samples`: of the first round.
  Search(CollisionChecker& checker, const JointLimits& limits, const PlannerParams& params,
         int first_samples = 500);

  /// The start and all goals must be free and within the limits. Ends without a path when `stop` says so or
  /// the trees are full.
  [[nodiscard]] std::optional<Found> run(const JointVector& start, const std::vector<JointVector>& goals,
                                         const std::function<bool()>& stop);
  /// run() in pieces: begin() once, then run_round() until it finds a path, `stop` said so or it is
  /// exhausted(). The rounds of two searches with the same seed are the same.
  void begin(const JointVector& start, const std::vector<JointVector>& goals);
  [[nodiscard]] std::optional<Found> run_round(const std::function<bool()>& stop);
  [[nodiscard]] bool exhausted() const { return whole_ && whole_->full(); }
  [[nodiscard]] std::optional<Found> straight(const JointVector& start,
                                              const std::vector<JointVector>& goals);
  /// In the trees of all searches.
  [[nodiscard]] int states() const { return states_ + (whole_ ? whole_->states() : 0); }

 private:
  std::optional<Found> branch_after_branch(const JointVector& start, const JointVector& goal,
                                           const std::vector<JointSet>& order, int samples,
                                           const std::function<bool()>& stop);

  CollisionChecker& checker_;
  JointLimits limits_;
  PlannerParams params_;
  std::vector<JointSet> branches_;
  Rng rng_;
  std::optional<RrtConnect> whole_;  ///< all joints at once; grows from round to round
  JointVector start_, nearest_goal_;
  int nearest_{0};
  int samples_;
  int states_{0};  ///< but those of whole_
};

}  // namespace extperfc::arm
