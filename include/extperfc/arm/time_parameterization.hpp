#pragma once

#include <vector>

#include "extperfc/arm/joint_path.hpp"
#include "extperfc/arm/joint_trajectory.hpp"
#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/base/error.hpp"

namespace extperfc::arm {

struct TimeParams {
  double velocity_scale{1};      ///< of the velocity limits, (0, 1]
  double acceleration_scale{1};  ///< of the acceleration limits, (0, 1]
  /// Speed ds/dt on the path at its start, where a motion goes on: the norm of the joints' velocity, which
  /// has to point along the path [rad/s], >= 0. Not with jerk limits: those start and end at rest.
  double start_speed{0};
  double end_speed{0};  ///< the same at the end
  /// Grid of a rounded corner, [4, 200]. On random paths 8 stages cost 2 % of the duration, 16 1 %, 32 0.5 %.
  int stages_per_corner{16};
  /// With jerk limits: how far smoothing may move the motion off the path, Euclidean norm [rad], (0, 1].
  double smoothing_deviation_rad{0.01};
};

/// The fastest motion along a path that starts and ends at rest (or with the speeds given) and keeps the
/// limits at every instant, not at samples only: see src/arm/trajectory/reachability.hpp for the algorithm
/// (reachability analysis, Pham and Pham 2018) and for why bounds hold between grid points. Optimal on
/// straights; around corners to within the grid.
///
/// With jerk limits the motion is the moving average (see JointTrajectory) of a fastest motion without them,
/// over a window that is just long enough; a motion may be made from lower accelerations where that allows a
/// shorter window and is faster in the end. From stop to stop a straight motion takes at most 3.1 % longer
/// than the fastest one (measured, 1e-7 to 3 rad); at corners there is no such bound. Between stops there is
/// a window each.
///
/// The same input gives the same trajectory. O(waypoints x stages_per_corner x joints); with jerk limits some
/// ten times that. Errors (kInvalidArgument): limits of the wrong size, not positive or not finite,
/// parameters out of range, a start speed that no motion within the limits has, boundary speeds with jerk
/// limits.
[[nodiscard]] Result<JointTrajectory> parameterize(const JointPath& path, const TrajectoryLimits& limits,
                                                   const TimeParams& params = {});

/// Path and time parameterization in one call. With jerk limits corners and smoothing get half of
/// `deviation_rad` each, with 0 the motion stops at every waypoint: deviation_rad() of the result is
/// `deviation_rad` at most. `params.smoothing_deviation_rad` does not count.
[[nodiscard]] Result<JointTrajectory> parameterize(const std::vector<JointVector>& waypoints,
                                                   double deviation_rad, const TrajectoryLimits& limits,
                                                   const TimeParams& params = {});

}  // namespace extperfc::arm
