#pragma once

#include <vector>

#include <Eigen/Core>

#include "extperfc/depth/object_fit.hpp"

/// Solids that stand on the plane z = 0, each given by up to four numbers:
/// sphere (x, y, radius), cone (x, y, radius, height), cube (x, y, edge, yaw).
namespace extperfc::depth {

inline constexpr int kMaxNumbers = 4;
using Numbers = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxNumbers, 1>;

/// How many numbers a solid has: 3 or 4.
[[nodiscard]] int number_count(FitShape shape);

/// Signed distance of a point from the solid's visible surface [m]; positive outside.
[[nodiscard]] double distance(FitShape shape, const Numbers& numbers, const Eigen::Vector3d& point);

/// Full extents along the solid's own axes [m].
[[nodiscard]] Eigen::Vector3d size_of(FitShape shape, const Numbers& numbers);

/// Half of the points' extent sideways, which the camera sees in full: a sphere's or a cone's radius [m].
[[nodiscard]] double half_width(const std::vector<Eigen::Vector3d>& points);

/// Where a search begins, from the points that stand out of the plane (at least one); several for a cube,
/// whose yaw is unknown. x of the frame points away from the camera.
[[nodiscard]] std::vector<Numbers> starts(FitShape shape, const std::vector<Eigen::Vector3d>& points);

}  // namespace extperfc::depth
