#pragma once

#include <functional>

#include <Eigen/Core>

#include "extperfc/world/pose.hpp"

#include "mapping/scan_points.hpp"
#include "mapping/surface_map.hpp"

namespace extperfc::mapping {

/// Prior of a match: a normal distribution of the pose, independent in x, y and yaw, and narrower along one
/// direction when that is given.
struct PosePrior {
  Pose2 mean;
  double sigma_m{1};            ///< [m]
  double sigma_rad{0.5};        ///< [rad]
  Eigen::Vector2d along{0, 0};  ///< in the map's frame, of unit length; zero: no direction is special
  double sigma_along_m{1};      ///< [m], what is known along it besides sigma_m
};

struct ScanMatch {
  Pose2 pose;                   ///< of the base in the map's frame
  Eigen::Matrix3d information;  ///< of x, y, yaw by the scan alone [1/m^2, 1/m, 1/rad^2]
  double fit{0};                ///< fraction of the points that lie on a surface of the map, [0, 1]
  int used{0};                  ///< points that found a surface
};

/// Moves the scan until its points lie on the map's lines (Gauss-Newton on point-to-line distances with a
/// Geman-McClure weight; Censi 2008 for the metric), held by the prior. `reach_m` bounds how far a point
/// looks for its surface at first; it shrinks as the match settles.
[[nodiscard]] ScanMatch match(const SurfaceMap& map, const ScanPoints& points, const Pose2& start,
                              const PosePrior& prior, double reach_m);

/// Fit and information at a pose, without moving it.
[[nodiscard]] ScanMatch evaluate(const SurfaceMap& map, const ScanPoints& points, const Pose2& pose);

/// Fraction of the points that lie on a surface, graded by how near they lie, [0, 1].
[[nodiscard]] double graded_fit(const SurfaceMap& map, const ScanPoints& points, const Pose2& pose);

/// How the points of a scan compare with a map at a pose, in points.
struct Agreement {
  double on_surface{0};    ///< graded by how near they lie, as in graded_fit()
  double near_surface{0};  ///< lie so near to a surface that they should lie on it
  double all{0};

  /// Of the points near a surface, the fraction on it. Unlike a fraction of all points it does not grow when
  /// a pose brings more of the scan into what the map has seen.
  [[nodiscard]] double ratio() const { return near_surface > 0 ? on_surface / near_surface : 0.0; }
};
[[nodiscard]] Agreement agreement(const SurfaceMap& map, const ScanPoints& points, const Pose2& pose);

/// A match in surroundings that may look alike along one direction, as corridors do: the likelihood, from
/// `score`, along the weakest direction, `window_m` or 1 m on both sides of the prior's mean (Olson,
/// Real-Time Correlative Scan Matching, 2009). A narrow peak inside the window restarts the match there.
/// Otherwise the scan does not determine the position along that direction: it stays as near to the prior as
/// is likely, and has no information along it, so that the prior is not taken for a measurement.
[[nodiscard]] ScanMatch match_along(const SurfaceMap& map, const ScanPoints& points, const ScanMatch& first,
                                    const PosePrior& prior, double window_m, double reach_m,
                                    const std::function<double(const Pose2&)>& score);

/// The pose on a grid around `centre` at which most points lie near a surface: a coarse start for match()
/// after wheels slipped or a jump. Cost grows with the square of `window_m`.
[[nodiscard]] Pose2 search_near(const SurfaceMap& map, const ScanPoints& points, const Pose2& centre,
                                double window_m, double window_rad);

}  // namespace extperfc::mapping
