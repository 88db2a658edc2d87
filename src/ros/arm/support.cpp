#include "ros/arm/support.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

namespace extperfc::arm_node {

namespace {

constexpr double kBelow = 0.01;  ///< an object's support ends at most this far above its bottom [m]

}  // namespace

std::pair<double, double> heights(const Geometry& geometry, const Pose& root_T_shape) {
  const Eigen::Vector3d up = root_T_shape.linear().transpose().col(2);  // the root's z in the shape's frame
  double half = 0;
  if (const auto* box = std::get_if<Box>(&geometry))
    half = 0.5 * up.cwiseAbs().dot(box->size_m);
  else if (const auto* sphere = std::get_if<Sphere>(&geometry))
    half = sphere->radius_m;
  else if (const auto* cylinder = std::get_if<Cylinder>(&geometry))
    half = 0.5 * cylinder->length_m * std::abs(up.z()) + cylinder->radius_m * std::hypot(up.x(), up.y());
  else if (const auto* cone = std::get_if<Cone>(&geometry))
    half = 0.5 * cone->height_m * std::abs(up.z()) + cone->radius_m * std::hypot(up.x(), up.y());
  const double z = root_T_shape.translation().z();
  const auto* mesh = std::get_if<TriangleMesh>(&geometry);
  if (mesh == nullptr || !mesh->triangles) return {z - half, z + half};
  std::pair<double, double> all{std::numeric_limits<double>::infinity(),
                                -std::numeric_limits<double>::infinity()};
  for (const auto& triangle : *mesh->triangles)
    for (const auto& corner : triangle) {
      const double at = z + up.dot(corner.cast<double>().cwiseProduct(mesh->scale));
      all = {std::min(all.first, at), std::max(all.second, at)};
    }
  return all;
}

std::pair<double, double> heights(const std::vector<Shape>& shapes, const Pose& root_T_object) {
  std::pair<double, double> all{std::numeric_limits<double>::infinity(),
                                -std::numeric_limits<double>::infinity()};
  for (const auto& shape : shapes) {
    const auto one = heights(shape.geometry, root_T_object * shape.body_T_shape);
    all = {std::min(all.first, one.first), std::max(all.second, one.second)};
  }
  return all;
}

void allow_support(arm::CollisionWorld& world, const std::string& object, double bottom_z_m) {
  std::vector<std::string> below;
  for (const auto& [name, placed] : world.objects())
    if (name != object &&
        heights(placed->object.shapes, placed->object.root_T_object).second <= bottom_z_m + kBelow)
      below.push_back(name);
  for (const auto& name : below) world.allow(object, name);
}

}  // namespace extperfc::arm_node
