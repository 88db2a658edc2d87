#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/world/shape.hpp"

namespace extperfc::simulate {

/// A closed solid of revolution about z, its middle at the origin. `profile` holds (radius, height) from the
/// bottom upwards, at least two points, in any common unit; with few `corners` (at least 3) it is a prism or
/// a pyramid. `size_m` are the full lengths of the box around it. The name is for messages.
[[nodiscard]] TriangleMesh lathe(const std::string& name, const std::vector<Eigen::Vector2d>& profile,
                                 int corners, const Eigen::Vector3d& size_m);

// Profiles of unit height and radius 1 at the widest place.
[[nodiscard]] std::vector<Eigen::Vector2d> ellipse_profile();
[[nodiscard]] std::vector<Eigen::Vector2d> egg_profile();
[[nodiscard]] std::vector<Eigen::Vector2d> dome_profile();
/// A cone without its tip; `top` is the radius up there, [0, 1].
[[nodiscard]] std::vector<Eigen::Vector2d> frustum_profile(double top);
[[nodiscard]] std::vector<Eigen::Vector2d> vase_profile(double waist);

}  // namespace extperfc::simulate
