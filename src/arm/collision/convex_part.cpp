#include "arm/collision/convex_part.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "extperfc/world/stl.hpp"

#include "arm/collision/hull.hpp"

namespace extperfc::arm {
namespace {

constexpr double kSmallest = 1e-4;  // [m]
constexpr double kLargest = 1000;   // [m]

using Made = Result<ConvexPart>;

Made round_or_box(PartKind kind, const Eigen::Vector3d& half) {
  if (!half.allFinite() || half.minCoeff() < kSmallest || half.maxCoeff() > kLargest)
    return fail(ErrorCode::kInvalidArgument, "sizes of a shape must be from 0.0002 to 2000 m");
  ConvexPart part;
  part.kind = kind;
  part.half = half;
  return part;
}

Made make(const Box& box) {
  return round_or_box(PartKind::kBox, box.size_m / 2);
}

Made make(const Cylinder& cylinder) {
  return round_or_box(PartKind::kCylinder, {cylinder.radius_m, cylinder.radius_m, cylinder.length_m / 2});
}

Made make(const Sphere& sphere) {
  return round_or_box(PartKind::kSphere, Eigen::Vector3d::Constant(sphere.radius_m));
}

Made make(const Cone& cone) {
  return round_or_box(PartKind::kCone, {cone.radius_m, cone.radius_m, cone.height_m / 2});
}

Made make(const TriangleMesh& mesh) {
  const auto triangles = triangles_of(mesh);
  if (!triangles) return tl::unexpected<Error>(triangles.error());
  if (!mesh.scale.allFinite() || mesh.scale.cwiseAbs().minCoeff() <= 0)
    return fail(ErrorCode::kInvalidArgument,
                "scale of mesh " + mesh.path.string() + " must be finite and not 0");
  std::vector<Eigen::Vector3d> corners;
  corners.reserve(3 * (*triangles)->size());
  for (const auto& triangle : **triangles)
    for (const auto& corner : triangle) corners.emplace_back(corner.cast<double>().cwiseProduct(mesh.scale));
  auto hull = convex_hull(corners);
  if (!hull) return fail(hull.error().code, "mesh " + mesh.path.string() + ": " + hull.error().message);
  return hull;
}

Eigen::Vector3d cylinder_support(const Eigen::Vector3d& half, const Eigen::Vector3d& direction) {
  const double across = direction.head<2>().norm();
  const double scale = across > 0 ? half.x() / across : 0;
  return {scale * direction.x(), scale * direction.y(), direction.z() < 0 ? -half.z() : half.z()};
}

Eigen::Vector3d cone_support(const Eigen::Vector3d& half, const Eigen::Vector3d& direction) {
  const double across = direction.head<2>().norm();
  if (direction.z() * half.z() >= half.x() * across - direction.z() * half.z()) return {0, 0, half.z()};
  const double scale = across > 0 ? half.x() / across : 0;
  return {scale * direction.x(), scale * direction.y(), -half.z()};
}

Eigen::Vector3d hull_support(const std::vector<Eigen::Vector3d>& vertices, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d* best = vertices.data();
  double farthest = best->dot(direction);
  for (const auto& vertex : vertices)
    if (const double along = vertex.dot(direction); along > farthest) {
      farthest = along;
      best = &vertex;
    }
  return *best;
}

}  // namespace

Result<std::shared_ptr<const ConvexPart>> make_convex_part(const Shape& shape) {
  auto part = std::visit([](const auto& geometry) { return make(geometry); }, shape.geometry);
  if (!part) return tl::unexpected<Error>(part.error());
  if (!shape.body_T_shape.matrix().allFinite())
    return fail(ErrorCode::kInvalidArgument, "pose of a shape is not finite");
  part->body_T_part = shape.body_T_shape * part->body_T_part;
  return std::make_shared<const ConvexPart>(std::move(*part));
}

Result<Parts> make_convex_parts(const std::string& owner, const std::vector<Shape>& shapes) {
  Parts parts;
  for (const Shape& shape : shapes) {
    auto part = make_convex_part(shape);
    if (!part) return fail(part.error().code, owner + ": " + part.error().message);
    parts.push_back(std::move(*part));
  }
  return parts;
}

Eigen::Vector3d support(const ConvexPart& part, const Eigen::Vector3d& direction) {
  switch (part.kind) {
    case PartKind::kBox:
      return (direction.array() < 0).select(-part.half, part.half);
    case PartKind::kCylinder:
      return cylinder_support(part.half, direction);
    case PartKind::kSphere: {
      const double length = direction.norm();
      return length > 0 ? Eigen::Vector3d(part.half.x() / length * direction) : Eigen::Vector3d::Zero();
    }
    case PartKind::kCone:
      return cone_support(part.half, direction);
    case PartKind::kHull:
      break;
  }
  return hull_support(part.vertices, direction);
}

double bounding_radius(const ConvexPart& part) {
  switch (part.kind) {
    case PartKind::kBox:
      return part.half.norm();
    case PartKind::kSphere:
      return part.half.x();
    case PartKind::kCylinder:
    case PartKind::kCone:
      return std::hypot(part.half.x(), part.half.z());
    case PartKind::kHull:
      break;
  }
  double farthest = 0;
  for (const auto& vertex : part.vertices) farthest = std::max(farthest, vertex.norm());
  return farthest;
}

Eigen::Vector3d rotated_half(const ConvexPart& part, const Eigen::Matrix3d& rotation) {
  if (part.kind == PartKind::kSphere) return part.half;
  if (part.kind == PartKind::kBox || part.kind == PartKind::kHull) return rotation.cwiseAbs() * part.half;
  const Eigen::Array3d along = rotation.col(2).array().abs();
  return along * part.half.z() + part.half.x() * (1 - along.square()).max(0).sqrt();
}

double distance_bound(const ConvexPart& part, const Eigen::Vector3d& point) {
  const double across = point.head<2>().norm();
  switch (part.kind) {
    case PartKind::kBox:
      return (point.cwiseAbs() - part.half).cwiseMax(0).norm();
    case PartKind::kSphere:
      return point.norm() - part.half.x();
    case PartKind::kCylinder:
      return std::hypot(std::max(across - part.half.x(), 0.0),
                        std::max(std::abs(point.z()) - part.half.z(), 0.0));
    case PartKind::kCone: {
      const double slope = std::hypot(2 * part.half.z(), part.half.x());
      const double side = (2 * part.half.z() * across + part.half.x() * (point.z() - part.half.z())) / slope;
      return std::max(side, -part.half.z() - point.z());
    }
    case PartKind::kHull:
      break;
  }
  double bound = (point.cwiseAbs() - part.half).maxCoeff();
  for (const Plane& plane : part.planes) bound = std::max(bound, plane.normal.dot(point) - plane.offset);
  return bound;
}

}  // namespace extperfc::arm
