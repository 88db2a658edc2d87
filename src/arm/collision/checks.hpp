#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"

#include "arm/collision/exact_pairs.hpp"
#include "arm/collision/kernel_scene.hpp"
#include "arm/collision/scene.hpp"

namespace extperfc::arm {

/// What a CollisionChecker holds.
class Checks {
 public:
  Checks(const CollisionModel& model, const CollisionWorld& world, const CollisionCheckerParams& params,
         Scene scene);

  /// For each state: 1 free, 0 not. With `exact`, pairs that the spheres do not clear go to GJK; else they
  /// count as not free. O(states * pairs).
  [[nodiscard]] std::vector<bool> states_free(const JointVector* states, int count, bool exact);
  [[nodiscard]] std::optional<Contact> contact(const JointVector& positions);
  [[nodiscard]] std::optional<Contact> nearest(const JointVector& positions);
  /// Largest proven fraction of the motion; -1 when not even its start is free. With `whole_only`, anything
  /// below 1 may be returned as soon as some piece is not proven. `deviation_rad` as in
  /// CollisionChecker::motion_free().
  [[nodiscard]] double free_fraction(const JointVector& from, const JointVector& to, bool whole_only,
                                     double deviation_rad = 0);

  /// Throws std::invalid_argument unless the size is right; false when a value is not finite.
  [[nodiscard]] bool usable(const JointVector& positions) const;

  const CollisionModel model;
  const CollisionWorld world;
  const CollisionCheckerParams params;
  CollisionCounters counters;

 private:
  friend class MotionProof;

  [[nodiscard]] const Bodies& bodies() const { return model.bodies(); }
  /// Runs the kernel on what is in memory_.positions().
  int run_kernel(const KernelMotion* motion);
  void pack(int lane, const JointVector& positions);
  [[nodiscard]] unsigned free_lanes(const JointVector* states, int count, bool exact);
  /// Whether GJK finds all flagged pairs of one lane apart.
  [[nodiscard]] bool lane_apart(const JointVector& positions, int flags, unsigned lane_bit);
  [[nodiscard]] bool pair_apart(int pair, const BodyPlacement& placement, double beyond_padding_m);
  [[nodiscard]] bool all_apart(const JointVector& positions);
  [[nodiscard]] Contact named(int pair, double distance_m) const;

  Scene scene_;
  KernelTables tables_;
  KernelScene kernel_scene_;
  KernelFunction kernel_;
  KernelMemory memory_;
  ExactPairs exact_;
  std::vector<std::vector<double>> farthest_;  ///< per body: the largest AxisReach::from_axis of its parts
  std::vector<bool> wraps_;                    ///< per joint: a full revolution changes nothing
  BodyPlacement placement_;
};

}  // namespace extperfc::arm
