#pragma once

#include <array>
#include <vector>

#include "arm/collision/checks.hpp"

namespace extperfc::arm {

/// The proof that a straight motion in joint space is free; the argument stands at
/// CollisionChecker::motion_free().
///
/// The motion, parameter 0 to 1, is cut into equal intervals, a multiple of the kernel's lanes and so many
/// that the bend of no body exceeds 2 mm. The spheres clear pairs over whole intervals; a pair that they do
/// not clear is proven by the separating plane that GJK finds, over halves of halves of the interval where
/// needed.
class MotionProof {
 public:
  /// `deviation_rad` as in CollisionChecker::motion_free().
  MotionProof(Checks& checks, const JointVector& from, const JointVector& to, double deviation_rad);
  /// As Checks::free_fraction().
  [[nodiscard]] double fraction(bool whole_only);

 private:
  void bound_drifts();
  void count_intervals();
  [[nodiscard]] JointVector at(double parameter) const { return from_ + parameter * delta_; }
  /// Bit i: interval of lane i proven. Lane i is interval first + i * stride.
  [[nodiscard]] unsigned proven_lanes(int first, int stride);
  [[nodiscard]] bool lane_proven(double middle, int flags, unsigned lane_bit);
  [[nodiscard]] bool all_pairs_proven(double middle);
  void set_moment(Moment& moment, double parameter) const;
  [[nodiscard]] MotionBound part_bound(int ancestor, int body, const std::vector<double>& from_axis) const;
  [[nodiscard]] MotionBound pair_bound(int pair) const;
  [[nodiscard]] bool pair_proven(int pair, const MotionBound& bound, double middle, double half, int depth);
  [[nodiscard]] bool halves_proven(int pair, const MotionBound& bound, double middle, double half, int depth);

  static constexpr int kMaxDepth = 24;

  Checks& checks_;
  const JointVector from_, delta_;
  const double length_;
  const double deviation_rad_;
  std::vector<double> rates_;  ///< per body
  std::vector<MotionBound> world_bounds_, self_bounds_;
  std::vector<float> kernel_rates_;
  std::vector<KernelDrift> world_drift_, self_drift_;
  int intervals_{0};
  double half_{0};
  std::array<Moment, kMaxDepth> moments_;  ///< one per depth of halving
};

}  // namespace extperfc::arm
