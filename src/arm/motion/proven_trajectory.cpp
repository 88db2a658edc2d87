#include "arm/motion/proven_trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "arm/motion/spline_proof.hpp"
#include "arm/planning/states.hpp"

namespace extperfc::arm {

namespace {

constexpr double kChordError = 1e-4;       // [rad]
constexpr double kMinDeviation = 1e-3;     // a corner rounded by less is stopped at [rad]
constexpr double kFinestTolerance = 1e-7;  // of the points; the last one tried [rad]
constexpr double kFiner = 0.1;

/// q'' of a corner is c (6 x - 6 x^2) / length with its direction_change c: 1.5 |c| / length at most. A chord
/// over ds leaves a curve by at most ds^2 / 8 of that; the points leave the curve by `tolerance_rad` more in
/// each joint.
bool corner_free(CollisionChecker& checker, const PathPiece& corner, double tolerance_rad) {
  const double curvature = 1.5 * corner.direction_change.norm() / corner.length;
  const double chord = std::sqrt(8.0 * kChordError / std::max(curvature, 1e-9));
  const int chords = 1 + static_cast<int>(corner.length / chord);
  const double deviation = std::min(kChordError, curvature * std::pow(corner.length / chords, 2) / 8) +
                           std::sqrt(static_cast<double>(corner.direction_change.size())) * tolerance_rad;
  JointVector from = corner.position;
  for (int i = 1; i <= chords; ++i) {
    const JointVector to = evaluate(corner, corner.length * i / chords).position;
    if (!checker.motion_free(from, to, deviation)) return false;
    from = to;
  }
  return true;
}

std::size_t nearest_waypoint(const std::vector<JointVector>& waypoints, const JointVector& position) {
  return static_cast<std::size_t>(nearest(waypoints, position));
}

/// Makes a corner rounder by half as little, or a stop.
void sharpen(double& deviation_rad) {
  deviation_rad = deviation_rad > 2.0 * kMinDeviation ? 0.5 * deviation_rad : 0.0;
}

/// Tries with less and less rounding, then with finer points, until the proof succeeds.
class Prover {
 public:
  Prover(CollisionChecker& checker, const std::vector<JointVector>& waypoints, const CornerParams& corners)
      : checker_(checker),
        waypoints_(waypoints),
        path_params_{1.0, corners.deviation_rad},
        proven_(waypoints.size(), false),
        tolerance_rad_(corners.point_tolerance_rad) {}

  Result<ProvenTrajectory> run(const TrajectoryLimits& limits, const TimeParams& times) {
    for (;;) {
      auto path = rounded_path();
      if (!path) return tl::unexpected(path.error());
      auto trajectory = parameterize(*path, limits, times);
      if (!trajectory) return tl::unexpected(trajectory.error());
      PointParams sampling;
      sampling.tolerance_rad = tolerance_rad_;
      auto points = to_points(*trajectory, sampling);
      if (!points) return tl::unexpected(points.error());
      const auto blocked = first_unproven(*points);
      if (!blocked) return ProvenTrajectory{std::move(*trajectory), std::move(*points), 0};
      if (!try_harder(*blocked))
        return fail(ErrorCode::kFailed, "clearance too small to prove the trajectory free");
    }
  }

  [[nodiscard]] const std::vector<double>& deviations() const { return path_params_.corner_deviation_rad; }

 private:
  /// With corners that are all proven.
  Result<JointPath> rounded_path() {
    auto path = JointPath::make(waypoints_, path_params_);
    while (path && sharpen_corners(*path)) path = JointPath::make(waypoints_, path_params_);
    return path;
  }

  /// Sharpens what corners are not free; false when all are.
  bool sharpen_corners(const JointPath& path) {
    bool changed = false;
    for (const auto& piece : path.pieces()) {
      if (piece.straight) continue;
      const auto corner = nearest_waypoint(waypoints_, evaluate(piece, 0.5 * piece.length).position);
      if (proven_[corner]) continue;
      if (corner_free(checker_, piece, tolerance_rad_)) {
        proven_[corner] = true;
        continue;
      }
      sharpen(path_params_.corner_deviation_rad[corner]);
      changed = true;
    }
    return changed;
  }

  /// Where the points' spline is not proven free.
  [[nodiscard]] std::optional<JointVector> first_unproven(const std::vector<TrajectoryPoint>& points) const {
    for (std::size_t i = 1; i < points.size(); ++i)
      if (proven_fraction(checker_, points[i - 1], points[i]) < 1)
        return JointVector(0.5 * (points[i - 1].position + points[i].position));
    return std::nullopt;
  }

  bool try_harder(const JointVector& blocked) {
    double& deviation = path_params_.corner_deviation_rad[nearest_waypoint(waypoints_, blocked)];
    if (deviation > 0) {
      sharpen(deviation);
      return true;
    }
    tolerance_rad_ *= kFiner;
    return tolerance_rad_ >= kFinestTolerance;
  }

  CollisionChecker& checker_;
  const std::vector<JointVector>& waypoints_;
  JointPathParams path_params_;
  std::vector<bool> proven_;  ///< corners, by their waypoints; sharper ones of them too
  double tolerance_rad_;
};

}  // namespace

Result<ProvenTrajectory> prove_trajectory(CollisionChecker& checker,
                                          const std::vector<JointVector>& waypoints,
                                          const TrajectoryLimits& limits, const TimeParams& times,
                                          const CornerParams& corners) {
  Prover prover(checker, waypoints, corners);
  auto proven = prover.run(limits, times);
  if (!proven) return proven;
  for (std::size_t i = 0; i < waypoints.size(); ++i)
    if (prover.deviations()[i] < corners.deviation_rad[i]) ++proven->sharpened;
  return proven;
}

}  // namespace extperfc::arm
