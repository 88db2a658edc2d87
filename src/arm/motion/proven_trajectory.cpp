#include "arm/motion/proven_trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace extperfc::arm::motion {

namespace {

constexpr double kChordError = 1e-4;  // [rad]
constexpr double kLeast = 1e-3;       // a corner rounded by less is stopped at [rad]

/// q'' of a corner is turn * (6 x - 6 x^2) / length: 1.5 |turn| / length at most. A chord over ds leaves a
/// curve by at most ds^2 / 8 of that.
bool corner_free(CollisionChecker& checker, const PathPiece& corner) {
  const double curvature = 1.5 * corner.turn.norm() / corner.length;
  const double chord = std::sqrt(8.0 * kChordError / std::max(curvature, 1e-9));
  const int chords = 1 + static_cast<int>(corner.length / chord);
  JointVector from = corner.position;
  for (int i = 1; i <= chords; ++i) {
    const JointVector to = evaluate(corner, corner.length * i / chords).position;
    if (!checker.motion_free(from, to)) return false;
    from = to;
  }
  return true;
}

std::size_t nearest(const std::vector<JointVector>& waypoints, const JointVector& position) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    const double distance = (waypoints[i] - position).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    best = i;
  }
  return best;
}

/// Halves what corners that are not free may deviate; false when all are free.
bool sharpen(CollisionChecker& checker, const JointPath& path, const std::vector<JointVector>& waypoints,
             std::vector<double>* deviations, std::vector<bool>* proven) {
  bool changed = false;
  for (const auto& piece : path.pieces()) {
    if (piece.straight) continue;
    const auto corner = nearest(waypoints, evaluate(piece, 0.5 * piece.length).position);
    if ((*proven)[corner]) continue;
    if (corner_free(checker, piece)) {
      (*proven)[corner] = true;
      continue;
    }
    (*deviations)[corner] = (*deviations)[corner] > 2.0 * kLeast ? 0.5 * (*deviations)[corner] : 0.0;
    changed = true;
  }
  return changed;
}

}  // namespace

Result<ProvenTrajectory> prove_trajectory(CollisionChecker& checker,
                                          const std::vector<JointVector>& waypoints,
                                          const TrajectoryLimits& limits, const TimeParams& times,
                                          const CornerParams& corners) {
  JointPathParams params{1.0, corners.deviation_rad};
  std::vector<bool> proven(waypoints.size(), false);
  auto path = JointPath::make(waypoints, params);
  while (path && sharpen(checker, *path, waypoints, &params.corner_deviation_rad, &proven))
    path = JointPath::make(waypoints, params);
  if (!path) return tl::unexpected(path.error());
  auto trajectory = parameterize(*path, limits, times);
  if (!trajectory) return tl::unexpected(trajectory.error());
  PointParams sampling;
  sampling.tolerance_rad = corners.point_tolerance_rad;
  auto points = to_points(*trajectory, sampling);
  if (!points) return tl::unexpected(points.error());
  int sharpened = 0;
  for (std::size_t i = 0; i < waypoints.size(); ++i)
    if (params.corner_deviation_rad[i] < corners.deviation_rad[i]) ++sharpened;
  return ProvenTrajectory{std::move(*trajectory), std::move(*points), sharpened};
}

}  // namespace extperfc::arm::motion
