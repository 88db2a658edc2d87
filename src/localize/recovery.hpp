#pragma once

namespace extperfc::localize {

/// Augmented MCL (Probabilistic Robotics, table 8.3): the fraction of the particles to replace by
/// fresh ones, from a slow and a fast average of how well the scans fit.
///
/// The averages begin at the value of a localized robot, as if after kPriorUpdates: a robot whose first pose
/// is wrong has no better past to compare with. Until there were 1 / alpha updates each average is the plain
/// mean.
class Recovery {
 public:
  /// alpha_slow = 0 switches recovery off.
  Recovery(double alpha_slow, double alpha_fast) : alpha_slow_(alpha_slow), alpha_fast_(alpha_fast) {}

  /// Forgets the averages.
  void reset();
  /// `likelihood`: of a ray (geometric mean) at the estimated pose, (0, 1]. The book takes the mean weight
  /// of the particles, which falls too when they are merely spread wider. O(1).
  void add(double likelihood);
  /// max(0, 1 - fast / slow), 0 below 0.1: the averages of a localized robot differ that much.
  [[nodiscard]] double fraction() const;
  /// The slow average.
  [[nodiscard]] double usual() const { return slow_; }

 private:
  double alpha_slow_;
  double alpha_fast_;
  double slow_{kPrior};
  double fast_{kPrior};
  double updates_{kPriorUpdates};

  static constexpr double kPrior = 0.9;
  static constexpr double kPriorUpdates = 10;
};

}  // namespace extperfc::localize
