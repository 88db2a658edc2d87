#include "simulate/bodies/collision_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <BulletCollision/CollisionShapes/btShapeHull.h>

#include "extperfc/base/math.hpp"
#include "extperfc/world/stl.hpp"

#include "simulate/bodies/bullet_conversions.hpp"

namespace extperfc::simulate {
namespace {

using Part = Result<std::unique_ptr<btCollisionShape>>;

/// Bullet rounds the edges of convex shapes by this much [m]; its default of 4 cm is for crates. Boxes and
/// cylinders keep their size, cones and hulls grow by it.
constexpr double kMargin = 0.001;
constexpr double kGrowingMargin = 0.0002;
constexpr double kSmallest = 0.001;  // [m]
constexpr double kLargest = 1000;    // [m]

bool is_length(double value) {
  return value >= kSmallest && value <= kLargest;
}

Part bad_size(const std::string& owner, const char* what) {
  return fail(ErrorCode::kInvalidArgument,
              owner + ": size of a " + what + " must be from 0.001 to 1000 m in every direction");
}

Part with_margin(std::unique_ptr<btCollisionShape> shape, double margin = kMargin) {
  shape->setMargin(margin);
  return shape;
}

/// Hull of the mesh with a bounded number of corners.
Part make_hull(const TriangleMesh& mesh) {
  const auto triangles = triangles_of(mesh);
  if (!triangles) return tl::unexpected<Error>(triangles.error());
  btConvexHullShape all;
  all.setMargin(0);
  for (const auto& triangle : **triangles)
    for (const auto& corner : triangle)
      all.addPoint(to_bullet(Eigen::Vector3d(corner.cast<double>().cwiseProduct(mesh.scale))), false);
  all.recalcLocalAabb();
  btShapeHull reduced(&all);
  reduced.buildHull(0);
  auto hull = std::make_unique<btConvexHullShape>();
  for (int i = 0; i < reduced.numVertices(); ++i) hull->addPoint(reduced.getVertexPointer()[i], false);
  hull->recalcLocalAabb();
  return with_margin(std::move(hull), kGrowingMargin);
}

Part make_part(const std::string& owner, const Box& box) {
  if (!is_length(box.size_m.minCoeff()) || !is_length(box.size_m.maxCoeff())) return bad_size(owner, "box");
  return with_margin(std::make_unique<btBoxShape>(to_bullet(Eigen::Vector3d(box.size_m / 2))));
}

Part make_part(const std::string& owner, const Cylinder& c) {
  if (!is_length(c.radius_m) || !is_length(c.length_m)) return bad_size(owner, "cylinder");
  return with_margin(std::make_unique<btCylinderShapeZ>(btVector3(c.radius_m, c.radius_m, c.length_m / 2)));
}

Part make_part(const std::string& owner, const Sphere& sphere) {
  if (!is_length(sphere.radius_m)) return bad_size(owner, "sphere");
  return Part(std::make_unique<btSphereShape>(sphere.radius_m));
}

Part make_part(const std::string& owner, const Cone& cone) {
  if (!is_length(cone.radius_m) || !is_length(cone.height_m)) return bad_size(owner, "cone");
  return with_margin(std::make_unique<btConeShapeZ>(cone.radius_m, cone.height_m), kGrowingMargin);
}

Part make_part(const std::string& owner, const TriangleMesh& mesh) {
  if (!mesh.scale.allFinite() || mesh.scale.cwiseAbs().minCoeff() <= 0)
    return fail(ErrorCode::kInvalidArgument,
                owner + ": scale of mesh " + mesh.path.string() + " must be finite and not zero");
  return make_hull(mesh);
}

Part make_part(const std::string& owner, const Shape& shape) {
  if (!shape.body_T_shape.matrix().allFinite())
    return fail(ErrorCode::kInvalidArgument, owner + ": pose of a shape is not finite: check its numbers");
  return std::visit([&](const auto& geometry) { return make_part(owner, geometry); }, shape.geometry);
}

/// Density 1 kg/m^3, about the shape's origin.
MassProperties solid(const Box& b) {
  const Eigen::Vector3d squares = b.size_m.cwiseProduct(b.size_m);
  const double mass = b.size_m.prod();
  const Eigen::Vector3d moments = mass / 12 * (Eigen::Vector3d::Constant(squares.sum()) - squares);
  return {mass, Eigen::Vector3d::Zero(), moments.asDiagonal()};
}

MassProperties solid(const Cylinder& c) {
  const double r2 = c.radius_m * c.radius_m;
  const double mass = kPi * r2 * c.length_m;
  const double across = mass * (r2 / 4 + c.length_m * c.length_m / 12);
  return {mass, Eigen::Vector3d::Zero(), Eigen::Vector3d(across, across, mass * r2 / 2).asDiagonal()};
}

MassProperties solid(const Sphere& s) {
  const double mass = 4.0 / 3.0 * kPi * s.radius_m * s.radius_m * s.radius_m;
  return {mass, Eigen::Vector3d::Zero(), 0.4 * mass * s.radius_m * s.radius_m * Eigen::Matrix3d::Identity()};
}

MassProperties solid(const Cone& c) {
  const double r2 = c.radius_m * c.radius_m;
  const double mass = kPi * r2 * c.height_m / 3;
  const double across = mass * (3.0 / 20 * r2 + 3.0 / 80 * c.height_m * c.height_m);
  return {mass, {0, 0, -c.height_m / 4}, Eigen::Vector3d(across, across, 0.3 * mass * r2).asDiagonal()};
}

MassProperties solid(const TriangleMesh& mesh) {
  const auto triangles = triangles_of(mesh);
  if (!triangles) return {};
  Eigen::Vector3d low = (*triangles)->front()[0].cast<double>();
  Eigen::Vector3d high = low;
  for (const auto& triangle : **triangles) {
    for (const auto& corner : triangle) {
      low = low.cwiseMin(corner.cast<double>());
      high = high.cwiseMax(corner.cast<double>());
    }
  }
  const Eigen::Vector3d size = (high - low).cwiseProduct(mesh.scale.cwiseAbs()).cwiseMax(kSmallest);
  MassProperties box = solid(Box{size});
  box.com = (0.5 * (low + high)).cwiseProduct(mesh.scale);
  return box;
}

double thickness(const Geometry& geometry) {
  if (const auto* box = std::get_if<Box>(&geometry)) return box->size_m.minCoeff();
  if (const auto* sphere = std::get_if<Sphere>(&geometry)) return 2 * sphere->radius_m;
  if (const auto* cylinder = std::get_if<Cylinder>(&geometry))
    return std::min(2 * cylinder->radius_m, cylinder->length_m);
  if (const auto* cone = std::get_if<Cone>(&geometry)) return std::min(cone->radius_m, cone->height_m / 2);
  return 0.01;
}

}  // namespace

btCollisionShape* CollisionShape::add(std::unique_ptr<btCollisionShape> part) {
  parts_.push_back(std::move(part));
  return parts_.back().get();
}

Result<CollisionShape> CollisionShape::make(const std::string& owner, const std::vector<Shape>& shapes,
                                            const Pose& frame_T_body) {
  if (shapes.empty()) return placeholder();
  CollisionShape result;
  auto compound = std::make_unique<btCompoundShape>();
  for (const Shape& shape : shapes) {
    auto part = make_part(owner, shape);
    if (!part) return tl::unexpected<Error>(part.error());
    const Pose frame_T_shape = frame_T_body * shape.body_T_shape;
    btCollisionShape* const added = result.add(std::move(*part));
    if (shapes.size() == 1 && frame_T_shape.isApprox(Pose::Identity(), 1e-12)) {
      result.root_ = added;
      return result;
    }
    compound->addChildShape(to_bullet(frame_T_shape), added);
  }
  compound->setMargin(kMargin);
  result.root_ = result.add(std::move(compound));
  return result;
}

CollisionShape CollisionShape::placeholder() {
  CollisionShape result;
  result.root_ = result.add(std::make_unique<btSphereShape>(kSmallest));
  return result;
}

CollisionShape CollisionShape::capsule(double radius_m, double height_m) {
  CollisionShape result;
  btCollisionShape* const part =
      result.add(std::make_unique<btCapsuleShapeZ>(radius_m, height_m - 2 * radius_m));
  auto compound = std::make_unique<btCompoundShape>();
  compound->addChildShape(btTransform(btQuaternion::getIdentity(), {0, 0, height_m / 2}), part);
  result.root_ = result.add(std::move(compound));
  return result;
}

MassProperties solid_mass_properties(const std::vector<Shape>& shapes, double mass_kg) {
  MassProperties sum;
  for (const Shape& shape : shapes) {
    const auto part = std::visit([](const auto& geometry) { return solid(geometry); }, shape.geometry);
    sum = combined(sum, transformed(shape.body_T_shape, part));
  }
  const double density = sum.mass_kg > 0 ? mass_kg / sum.mass_kg : 0;
  return {mass_kg, sum.com, density * sum.inertia_kg_m2};
}

double thickness(const std::vector<Shape>& shapes) {
  double thinnest = std::numeric_limits<double>::infinity();
  for (const Shape& shape : shapes) thinnest = std::min(thinnest, thickness(shape.geometry));
  return thinnest;
}

}  // namespace extperfc::simulate
