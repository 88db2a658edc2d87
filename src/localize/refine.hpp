#pragma once

#include <Eigen/Core>

#include "localize/beams.hpp"
#include "localize/distance_field.hpp"

namespace extperfc::localize {

/// Distance to the nearest obstacle between the cells' middles (bilinear), with its slope.
struct SmoothDistance {
  float metres{0};
  float slope_x{0};  ///< along the map's own axes [m/m]
  float slope_y{0};
};
[[nodiscard]] SmoothDistance smooth_distance(const DistanceField& field, float x_m, float y_m);

constexpr double kRefineSigma_m = 0.05;  ///< of a scan against a map of 0.05 m cells

[[nodiscard]] bool is_near(const Pose2& a, const Pose2& b, double within_m, double within_rad);

/// Information that holds a pose within about a metre.
[[nodiscard]] inline Eigen::Matrix3d loose_prior() {
  return Eigen::Vector3d(1, 1, 10).asDiagonal();
}

struct Refined {
  Pose2 pose;                   ///< metres from the map's lower left corner, along its own axes
  Eigen::Matrix3d information;  ///< of the scan alone, in (x, y, yaw) at that pose
};

/// The pose near `start` where the end points lie best on the map's obstacles: Gauss-Newton on their
/// distances, each weighed by its probability of being a hit (z_hit against z_rand, at a sigma that shrinks
/// to `sigma_m`), and held to `start` with `prior_information`.
[[nodiscard]] Refined refine(const DistanceField& field, const Beams& beams, const Pose2& start,
                             const Eigen::Matrix3d& prior_information, double sigma_m, double rand_per_hit);

}  // namespace extperfc::localize
