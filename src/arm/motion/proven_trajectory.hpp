#pragma once

#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/joint_trajectory.hpp"
#include "extperfc/arm/time_parameterization.hpp"
#include "extperfc/base/error.hpp"

namespace extperfc::arm {

struct ProvenTrajectory {
  JointTrajectory trajectory;
  std::vector<TrajectoryPoint> points;  ///< for cubic interpolation
  int sharpened{0};                     ///< corners that had to be rounded less than asked
};

struct CornerParams {
  std::vector<double> deviation_rad;  ///< of each waypoint, see JointPathParams
  double point_tolerance_rad{5e-5};   ///< of one joint, between the points
};

/// The fastest motion along `waypoints`, whose straight segments were proven free. What is proven in the end
/// is the spline through the points, as the controller follows it. Where that does not succeed, corners are
/// rounded less or stopped at, then the points are brought nearer to the path; with no rounding at all
/// everything is on the straight segments. Errors: something is so near that not even that can be proven
/// (kFailed); those of parameterize().
[[nodiscard]] Result<ProvenTrajectory> prove_trajectory(CollisionChecker& checker,
                                                        const std::vector<JointVector>& waypoints,
                                                        const TrajectoryLimits& limits,
                                                        const TimeParams& times, const CornerParams& corners);

}  // namespace extperfc::arm
