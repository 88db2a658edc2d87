#pragma once

#include <optional>

#include <Eigen/Core>

#include "depth/object_fit/points.hpp"

namespace extperfc::depth {

/// The plane that an object stands on, and a frame in it.
struct SupportPlane {
  Pose camera_T_plane{Pose::Identity()};  ///< origin under the object, z the normal, x away from the camera
  double height_sigma_m{0};               ///< standard deviation of the plane's height at its origin [m]
  int pixels{0};
};

/// The plane around the box; empty when fewer than min_support_px pixels agree on one. `up` is a unit
/// vector, `anchor` a point of the object's surface, both in the optical frame.
[[nodiscard]] std::optional<SupportPlane> find_support(const Points& points, const Eigen::Vector3d& up,
                                                       const Eigen::Vector3d& anchor,
                                                       const ObjectFitParams& params);

/// True when a point lies higher over the support than noise explains, and by 2 mm at least.
[[nodiscard]] bool rises(const SupportPlane& support, const Point& point);

}  // namespace extperfc::depth
