#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "extperfc/arm/joint_path.hpp"
#include "extperfc/arm/joint_trajectory.hpp"
#include "extperfc/base/rng.hpp"

namespace extperfc::arm {

inline JointVector random_vector(Rng& rng, int joints, double low, double high) {
  JointVector vector(joints);
  for (int j = 0; j < joints; ++j) vector[j] = rng.uniform(low, high);
  return vector;
}

inline std::vector<JointVector> random_waypoints(Rng& rng, int joints, int count, double step_rad) {
  std::vector<JointVector> waypoints{random_vector(rng, joints, -1, 1)};
  while (static_cast<int>(waypoints.size()) < count)
    waypoints.emplace_back(waypoints.back() + random_vector(rng, joints, -step_rad, step_rad));
  return waypoints;
}

inline TrajectoryLimits random_limits(Rng& rng, int joints, bool with_jerk) {
  TrajectoryLimits limits;
  limits.velocity = random_vector(rng, joints, 0.5, 4);
  limits.acceleration = random_vector(rng, joints, 1, 12);
  if (with_jerk) limits.jerk = random_vector(rng, joints, 10, 120);
  return limits;
}

inline double distance_to_line(const JointVector& point, const JointVector& a, const JointVector& b) {
  const JointVector delta = b - a;
  const double length = delta.squaredNorm();
  const double fraction = length > 0 ? std::clamp((point - a).dot(delta) / length, 0.0, 1.0) : 0.0;
  return (point - a - fraction * delta).norm();
}

inline double distance_to_polyline(const JointVector& point, const std::vector<JointVector>& waypoints) {
  double smallest = (point - waypoints.front()).norm();
  for (std::size_t i = 1; i < waypoints.size(); ++i)
    smallest = std::min(smallest, distance_to_line(point, waypoints[i - 1], waypoints[i]));
  return smallest;
}

/// Largest |value| / limit.
inline double use(const JointVector& values, const JointVector& limit) {
  return (values.array() / limit.array()).abs().maxCoeff();
}

/// Time from rest to rest over `distance` with bounded speed and acceleration.
inline double trapezoid_s(double distance, double speed, double acceleration) {
  if (distance * acceleration <= speed * speed) return 2 * std::sqrt(distance / acceleration);
  return distance / speed + speed / acceleration;
}

/// The same along the straight line between two points, all joints together.
inline double line_s(const JointVector& a, const JointVector& b, const TrajectoryLimits& limits) {
  const double length = (b - a).norm();
  const JointVector direction = (b - a) / length;
  return trapezoid_s(length, 1 / use(direction, limits.velocity), 1 / use(direction, limits.acceleration));
}

/// Of a motion that stops at every waypoint.
inline double stop_and_go_s(const std::vector<JointVector>& waypoints, const TrajectoryLimits& limits) {
  double sum = 0;
  for (std::size_t i = 1; i < waypoints.size(); ++i) sum += line_s(waypoints[i - 1], waypoints[i], limits);
  return sum;
}

}  // namespace extperfc::arm
