#pragma once

#include <vector>

#include "extperfc/arm/joint_path.hpp"
#include "extperfc/arm/joint_trajectory.hpp"
#include "extperfc/base/error.hpp"

#include "arm/trajectory/reachability.hpp"

namespace extperfc::arm {

/// Phases to be averaged over a window, from rest to rest.
struct SmoothPassage {
  std::vector<PathPhase> phases;
  double window_s{0};
  double deviation_rad{0};  ///< bound on what averaging moves the motion off the path, Euclidean norm

  [[nodiscard]] double duration_s() const {
    return phases.back().begin_s + phases.back().duration_s + window_s;
  }
};

/// A short window, found by bisection, whose moving average of `phases` keeps |jerk| <= limit: accelerations
/// a window apart differ by limit x window at most, taken over the ranges that they have in each phase.
/// O(phases x joints).
[[nodiscard]] double smoothing_window(const JointPath& path, const std::vector<PathPhase>& phases,
                                      const JointVector& jerk);

/// The shortest of some jerk-limited time parameterizations of a passage that starts and ends at rest. Lower
/// accelerations need shorter windows: limits of acceleration are tried in steps of a square root of two
/// downwards until the duration rises, with and without holding the speed between gaining and losing it
/// (Passage::hold_s), and only laws count whose averaging keeps within `deviation_rad` of the path (without
/// corners it never leaves it).
[[nodiscard]] Result<SmoothPassage> smooth_passage(const JointPath& path, const Passage& passage,
                                                   const TrajectoryLimits& limits, double deviation_rad,
                                                   int stages);

}  // namespace extperfc::arm
