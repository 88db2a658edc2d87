#include "extperfc/arm/robot_overlap.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <variant>

#include "arm/collision/bodies.hpp"

namespace extperfc::arm {
namespace {

constexpr double kStep = 0.005;  // [m]
constexpr int kMaxSteps = 16;    // along each axis

/// Points of a grid that are in the part, in its frame.
std::vector<Eigen::Vector3d> points_in(const ConvexPart& part) {
  Eigen::Vector3i steps;
  for (int axis = 0; axis < 3; ++axis)
    steps[axis] = std::clamp(static_cast<int>(std::ceil(2.0 * part.half[axis] / kStep)), 1, kMaxSteps);
  const Eigen::Vector3d step = 2.0 * part.half.cwiseQuotient(steps.cast<double>());
  std::vector<Eigen::Vector3d> points;
  for (int x = 0; x <= steps.x(); ++x)
    for (int y = 0; y <= steps.y(); ++y)
      for (int z = 0; z <= steps.z(); ++z) {
        const Eigen::Vector3d point = Eigen::Vector3d(x, y, z).cwiseProduct(step) - part.half;
        if (distance_bound(part, point) <= 1e-9) points.push_back(point);
      }
  return points;
}

bool any_within(const std::vector<Eigen::Vector3d>& points, const Pose& part_T_points,
                const ConvexPart& part) {
  return std::any_of(points.begin(), points.end(), [&](const Eigen::Vector3d& point) {
    return distance_bound(part, part_T_points * point) <= 0.0;
  });
}

bool overlaps(const Shape& shape, const Bodies& bodies, const std::vector<Pose>& poses) {
  if (std::holds_alternative<TriangleMesh>(shape.geometry)) return false;
  const auto part = make_convex_part(shape);
  if (!part) return false;
  const Pose& root_T_part = (*part)->body_T_part;
  const double radius = bounding_radius(**part);
  std::vector<Eigen::Vector3d> points;
  for (const auto& own : bodies.parts) {
    const Pose own_T_part = (poses[own.body] * own.body_T_part).inverse() * root_T_part;
    if (own_T_part.translation().norm() > radius + bounding_radius(*own.part)) continue;
    if (points.empty()) points = points_in(**part);
    if (any_within(points, own_T_part, *own.part)) return true;
  }
  return false;
}

}  // namespace

std::vector<bool> robot_overlaps(const CollisionModel& model, const JointVector& positions,
                                 const std::vector<Shape>& shapes) {
  std::vector<Pose> poses;
  body_poses(model.bodies(), positions.data(), poses);
  std::vector<bool> found;
  found.reserve(shapes.size());
  for (const auto& shape : shapes) found.push_back(overlaps(shape, model.bodies(), poses));
  return found;
}

}  // namespace extperfc::arm
