#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/shape.hpp"

namespace extperfc::arm {

enum class PartKind { kBox, kCylinder, kSphere, kCone, kHull };

/// Inside: normal . x <= offset; unit normal.
struct Plane {
  Eigen::Vector3d normal;
  double offset{0};
};

/// A convex solid about its own origin, which is the middle of its bounding box [m].
struct ConvexPart {
  PartKind kind{PartKind::kBox};
  Eigen::Vector3d half{
      Eigen::Vector3d::Zero()};           ///< of the bounding box; round shapes: radius, radius, half height
  std::vector<Eigen::Vector3d> vertices;  ///< hull only
  std::vector<Plane> planes;              ///< hull only: its faces
  Pose body_T_part{Pose::Identity()};
};

using Parts = std::vector<std::shared_ptr<const ConvexPart>>;

struct Ball {
  Eigen::Vector3d centre{Eigen::Vector3d::Zero()};
  double radius{0};
};

/// The solid of a shape. Errors: a size outside 1e-4 to 1000 m, a pose or corner that is not finite, an
/// unreadable or flat mesh.
[[nodiscard]] Result<std::shared_ptr<const ConvexPart>> make_convex_part(const Shape& shape);
/// All shapes; the error names `owner`.
[[nodiscard]] Result<Parts> make_convex_parts(const std::string& owner, const std::vector<Shape>& shapes);

/// A point of the part that is farthest in `direction` (not normalised; zero gives any point). O(1), hulls
/// O(vertices).
[[nodiscard]] Eigen::Vector3d support(const ConvexPart& part, const Eigen::Vector3d& direction);

/// Radius of a ball about the part's origin that holds it.
[[nodiscard]] double bounding_radius(const ConvexPart& part);

/// Half lengths of the axis-parallel box that contains the part rotated by `rotation`, about its origin.
[[nodiscard]] Eigen::Vector3d rotated_half(const ConvexPart& part, const Eigen::Matrix3d& rotation);

/// A lower bound of the distance of a point from the part, in the part's frame; exact for box, cylinder and
/// sphere seen from outside. Not positive inside.
[[nodiscard]] double distance_bound(const ConvexPart& part, const Eigen::Vector3d& point);

}  // namespace extperfc::arm
