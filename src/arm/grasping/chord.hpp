#pragma once

#include <optional>

#include <Eigen/Core>

#include "arm/collision/convex_part.hpp"

namespace extperfc::arm {

/// The piece of a line inside a solid, in the line's parameter [m].
struct Chord {
  double from{0};
  double to{0};
};

/// Where `point + t * direction` is inside the part; nothing when it passes by. `direction` is a unit vector,
/// both in the part's frame. No hulls: nothing for them. O(1).
[[nodiscard]] std::optional<Chord> chord(const ConvexPart& part, const Eigen::Vector3d& point,
                                         const Eigen::Vector3d& direction);

/// Unit normal, outwards, of the face that is nearest to a point of the surface, in the part's frame.
[[nodiscard]] Eigen::Vector3d outward_normal(const ConvexPart& part, const Eigen::Vector3d& point);

}  // namespace extperfc::arm
