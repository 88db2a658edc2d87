#include "ros/convert/shape_marker.hpp"

#include <cmath>
#include <type_traits>
#include <variant>

#include "ros/convert/geometry.hpp"

namespace extperfc::ros_convert {

namespace {

using visualization_msgs::Marker;

/// rviz has no cone: its side and its bottom as triangles.
void fill_cone(Marker& marker, const Cone& cone) {
  constexpr int kSides = 24;
  const auto rim = [&](int i) {
    const double angle = 2 * M_PI * i / kSides;
    return Eigen::Vector3d(cone.radius_m * std::cos(angle), cone.radius_m * std::sin(angle),
                           -0.5 * cone.height_m);
  };
  const Eigen::Vector3d tip(0, 0, 0.5 * cone.height_m);
  const Eigen::Vector3d middle(0, 0, -0.5 * cone.height_m);
  for (int i = 0; i < kSides; ++i)
    for (const auto& corner : {rim(i), rim(i + 1), tip, rim(i + 1), rim(i), middle})
      marker.points.push_back(to_point(corner));
  marker.type = Marker::TRIANGLE_LIST;
  marker.scale = to_vector({1, 1, 1});
}

void fill_mesh(Marker& marker, const TriangleMesh& mesh) {
  marker.scale = to_vector(mesh.scale);
  if (!mesh.triangles) {
    marker.type = Marker::MESH_RESOURCE;
    marker.mesh_resource = "file://" + mesh.path.string();
    return;
  }
  marker.type = Marker::TRIANGLE_LIST;
  for (const auto& triangle : *mesh.triangles)
    for (const auto& corner : triangle) marker.points.push_back(to_point(corner.cast<double>()));
}

}  // namespace

Marker to_marker(const Geometry& geometry) {
  Marker marker;
  marker.action = Marker::ADD;
  std::visit(
      [&](const auto& shape) {
        using Shape = std::decay_t<decltype(shape)>;
        if constexpr (std::is_same_v<Shape, Box>) {
          marker.type = Marker::CUBE;
          marker.scale = to_vector(shape.size_m);
        } else if constexpr (std::is_same_v<Shape, Cylinder>) {
          marker.type = Marker::CYLINDER;
          marker.scale = to_vector({2 * shape.radius_m, 2 * shape.radius_m, shape.length_m});
        } else if constexpr (std::is_same_v<Shape, Sphere>) {
          marker.type = Marker::SPHERE;
          marker.scale = to_vector(Eigen::Vector3d::Constant(2 * shape.radius_m));
        } else if constexpr (std::is_same_v<Shape, Cone>) {
          fill_cone(marker, shape);
        } else {
          fill_mesh(marker, shape);
        }
      },
      geometry);
  return marker;
}

}  // namespace extperfc::ros_convert
