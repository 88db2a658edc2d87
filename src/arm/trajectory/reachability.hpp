#pragma once

#include <cstddef>
#include <vector>

#include "extperfc/arm/joint_path.hpp"
#include "extperfc/arm/joint_trajectory.hpp"
#include "extperfc/base/error.hpp"

namespace extperfc::arm {

/// Pieces of a path that are passed without a stop inside, with the speeds at both ends.
struct Passage {
  std::size_t first_piece{0};
  std::size_t pieces{0};  ///< >= 1
  double start_speed{0};  ///< ds/dt [rad/s], >= 0
  double end_speed{0};    ///< ds/dt [rad/s], >= 0
  /// Between gaining and losing speed on a straight it is held this long at least [s], >= 0, on a lower speed
  /// where need be: a moving average then meets one jump of acceleration at a time.
  double hold_s{0};
};

/// Fastest time parameterization of a passage under bounds of velocity and acceleration, by reachability
/// analysis (Pham and Pham 2018, "A New Approach to Time-Optimal Path Parameterization Based on Reachability
/// Analysis", IEEE T-RO 34(3), algorithm 1): backwards the squared speeds from which the end can be reached,
/// forwards the largest of them. What differs from the paper:
///   - Straights are one stage each, solved in closed form: gain speed, hold it, lose it. Exact.
///   - A rounded corner is cut into `stages` stages of equal length; their bounds are put on the Bezier
///   points
///     of each joint's acceleration (StageShape) instead of its values at grid points: accelerations keep
///     their limits between grid points too. This takes the place of the paper's interpolation scheme, and
///     tames zero-inertia points likewise, as both ends of a stage are bounded at once.
///   - The linear program in (x, u) is one-dimensional in disguise: the smallest and largest u as functions
///   of
///     x are convex and concave piecewise linear, so Newton's method from outside finds the largest x where
///     they meet in finitely many steps.
///   - Velocity limits hold at grid points; where a stage exceeds them inside by its own bound, the speeds at
///     its ends are lowered and the passes run again.
/// Phases start at time 0 and have no gaps. Errors: speeds at the ends that no time parameterization within
/// the limits has. O(stages x joints).
[[nodiscard]] Result<std::vector<PathPhase>> fastest_phases(const JointPath& path, const Passage& passage,
                                                            const JointVector& velocity,
                                                            const JointVector& acceleration, int stages);

}  // namespace extperfc::arm
