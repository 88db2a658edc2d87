#pragma once

#include <string>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/joint_trajectory.hpp"
#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/base/error.hpp"

namespace extperfc::arm {

/// Points of a trajectory as a controller follows them: cubic splines through positions and velocities.
class TimedPath {
 public:
  /// Errors: no points, sizes that differ, values that are not finite, a negative time or times that do not
  /// grow.
  [[nodiscard]] static Result<TimedPath> make(std::vector<std::string> joints,
                                              std::vector<TrajectoryPoint> points);

  [[nodiscard]] const std::vector<std::string>& joints() const { return joints_; }
  [[nodiscard]] const std::vector<TrajectoryPoint>& points() const { return points_; }
  [[nodiscard]] double duration_s() const { return points_.back().time_s; }
  /// Before the first point: there; behind the last: there. O(log points).
  [[nodiscard]] JointVector position(double time_s) const;

  /// The joints with these names only, in this order. Error: one that the path does not have.
  [[nodiscard]] Result<TimedPath> only(const std::vector<std::string>& joints) const;

  /// Minimum over time of the largest joint distance [rad] from `measured` at times within [from_s, to_s],
  /// looked at every 10 ms and at both ends.
  [[nodiscard]] double deviation(const JointVector& measured, double from_s, double to_s) const;

  /// Largest time [s] up to which the motion from `from_s` on, as the controller follows it, is proven free;
  /// duration_s() when all of it is. The checker's joints are the path's, in its order.
  [[nodiscard]] double free_until(CollisionChecker& checker, double from_s) const;

 private:
  TimedPath(std::vector<std::string> joints, std::vector<TrajectoryPoint> points)
      : joints_(std::move(joints)), points_(std::move(points)) {}
  std::vector<std::string> joints_;
  std::vector<TrajectoryPoint> points_;
};

}  // namespace extperfc::arm
