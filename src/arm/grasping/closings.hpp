#pragma once

#include <vector>

#include <Eigen/Core>

#include "extperfc/arm/grasp.hpp"

#include "arm/collision/convex_part.hpp"

namespace extperfc::arm {

/// A direction in which fingers can close on an object, and where. The object is its own mirror image in the
/// plane through any of the centres across the direction.
struct Closing {
  Eigen::Vector3d along;                 ///< unit vector in the root frame
  std::vector<Eigen::Vector3d> centres;  ///< for the pads' middle, in the root frame; the best one first
};

/// All that are tried for a part at `root_T_part`.
[[nodiscard]] std::vector<Closing> closings_of(const ConvexPart& part, const Pose& root_T_part,
                                               const GraspParams& params);

/// Approaches square to a closing direction: unit vectors in the root frame, by the angle from the steepest
/// way down.
[[nodiscard]] std::vector<Eigen::Vector3d> approaches_of(const Eigen::Vector3d& along,
                                                         const GraspParams& params);

}  // namespace extperfc::arm
