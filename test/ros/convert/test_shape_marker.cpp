// Shapes as markers of rviz.
#include <algorithm>
#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "ros/convert/geometry.hpp"
#include "ros/convert/shape_marker.hpp"

namespace extperfc::ros_convert {
namespace {

using visualization_msgs::Marker;

void expect(const Marker& marker, int type, const Eigen::Vector3d& scale) {
  EXPECT_EQ(marker.type, type);
  EXPECT_EQ(marker.action, Marker::ADD);
  EXPECT_EQ(marker.scale, ros_convert::to_vector(scale));
}

TEST(ShapeMarker, SimpleShapes) {
  expect(ros_convert::to_marker(Box{{0.1, 0.2, 0.3}}), Marker::CUBE, {0.1, 0.2, 0.3});
  expect(ros_convert::to_marker(Sphere{0.1}), Marker::SPHERE, {0.2, 0.2, 0.2});
  expect(ros_convert::to_marker(Cylinder{0.1, 0.5}), Marker::CYLINDER, {0.2, 0.2, 0.5});
}

TEST(ShapeMarker, ConesAreTriangles) {
  const auto marker = ros_convert::to_marker(Cone{0.1, 0.4});
  expect(marker, Marker::TRIANGLE_LIST, {1, 1, 1});
  ASSERT_EQ(marker.points.size() % 3, 0U);
  const auto [low, high] = std::minmax_element(marker.points.begin(), marker.points.end(),
                                               [](const auto& a, const auto& b) { return a.z < b.z; });
  EXPECT_DOUBLE_EQ(low->z, -0.2);
  EXPECT_DOUBLE_EQ(high->z, 0.2);
  for (const auto& point : marker.points) EXPECT_LE(std::hypot(point.x, point.y), 0.1 + 1e-12);
}

TEST(ShapeMarker, MeshesInMemoryAreTrianglesAndOthersTheirFiles) {
  TriangleMesh mesh;
  mesh.path = "/models/a.stl";
  mesh.scale = {1, 2, 3};
  const auto file = ros_convert::to_marker(mesh);
  expect(file, Marker::MESH_RESOURCE, {1, 2, 3});
  EXPECT_EQ(file.mesh_resource, "file:///models/a.stl");
  mesh.triangles = std::make_shared<std::vector<Triangle>>(
      1, Triangle{Eigen::Vector3f{0, 0, 0}, Eigen::Vector3f{1, 0, 0}, Eigen::Vector3f{0, 1, 0}});
  const auto memory = ros_convert::to_marker(mesh);
  expect(memory, Marker::TRIANGLE_LIST, {1, 2, 3});
  ASSERT_EQ(memory.points.size(), 3U);
  EXPECT_EQ(memory.points[1].x, 1.0);
}

}  // namespace
}  // namespace extperfc::ros_convert
