#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "ros/convert/arm.hpp"

namespace extperfc::ros_convert {
namespace {

using shape_msgs::SolidPrimitive;

/// A tetrahedron with legs of 1 m along the axes.
shape_msgs::Mesh corner_mesh() {
  shape_msgs::Mesh mesh;
  for (const Eigen::Vector3d& at : {Eigen::Vector3d(0, 0, 0), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
    geometry_msgs::Point point;
    point.x = at.x();
    point.y = at.y();
    point.z = at.z();
    mesh.vertices.push_back(point);
  }
  for (const boost::array<std::uint32_t, 3>& face :
       {boost::array<std::uint32_t, 3>{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}}) {
    shape_msgs::MeshTriangle triangle;
    triangle.vertex_indices = face;
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

SolidPrimitive primitive(std::uint8_t type, std::vector<double> dimensions) {
  SolidPrimitive made;
  made.type = type;
  made.dimensions.assign(dimensions.begin(), dimensions.end());
  return made;
}

geometry_msgs::Pose pose_at(double x) {
  geometry_msgs::Pose pose;
  pose.position.x = x;
  pose.orientation.w = 1;
  return pose;
}

TEST(SceneShapes, ThereAndBackAgain) {
  extperfc::SceneObject message;
  message.primitives = {primitive(SolidPrimitive::BOX, {1, 2, 3}), primitive(SolidPrimitive::SPHERE, {0.5}),
                        primitive(SolidPrimitive::CYLINDER, {2, 0.25}),
                        primitive(SolidPrimitive::CONE, {2, 0.75})};
  message.primitive_poses = {pose_at(1), pose_at(2), pose_at(3), pose_at(4)};
  message.meshes = {corner_mesh()};
  message.mesh_poses = {pose_at(5)};
  const auto shapes = to_shapes(message);
  ASSERT_TRUE(shapes) << shapes.error().message;
  ASSERT_EQ(5U, shapes->size());
  EXPECT_EQ(2.0, std::get<Cylinder>((*shapes)[2].geometry).length_m);
  EXPECT_EQ(4U, std::get<TriangleMesh>((*shapes)[4].geometry).triangles->size());
  EXPECT_EQ(5.0, (*shapes)[4].body_T_shape.translation().x());
  extperfc::SceneObject back;
  fill_shapes(*shapes, back);
  EXPECT_EQ(message.primitives, back.primitives);
  EXPECT_EQ(message.primitive_poses, back.primitive_poses);
  EXPECT_EQ(message.mesh_poses, back.mesh_poses);
  ASSERT_EQ(1U, back.meshes.size());
  EXPECT_EQ(4U, back.meshes[0].vertices.size());  // each of them once
  const auto again = to_shapes(back);
  ASSERT_TRUE(again);
  EXPECT_EQ(*std::get<TriangleMesh>((*shapes)[4].geometry).triangles,
            *std::get<TriangleMesh>((*again)[4].geometry).triangles);
}

TEST(SceneShapes, WithoutPosesAllAreAtTheOrigin) {
  extperfc::SceneObject message;
  message.primitives = {primitive(SolidPrimitive::SPHERE, {0.5})};
  message.meshes = {corner_mesh()};
  const auto shapes = to_shapes(message);
  ASSERT_TRUE(shapes);
  for (const auto& shape : *shapes) EXPECT_TRUE(shape.body_T_shape.isApprox(Pose::Identity()));
}

TEST(SceneShapes, WhatMakesNoSenseIsRefusedWithAReason) {
  const auto error = [](const auto& spoil) {
    extperfc::SceneObject message;
    message.primitives = {primitive(SolidPrimitive::BOX, {1, 2, 3})};
    message.meshes = {corner_mesh()};
    spoil(message);
    const auto shapes = to_shapes(message);
    return shapes ? std::string() : shapes.error().message;
  };
  EXPECT_EQ("", error([](auto&) {}));
  EXPECT_NE("", error([](auto& m) { m.primitives[0].dimensions = {1, 2}; }));
  EXPECT_NE("", error([](auto& m) { m.primitives[0].dimensions[1] = -1; }));
  EXPECT_NE("", error([](auto& m) { m.primitives[0].dimensions[1] = std::nan(""); }));
  EXPECT_NE("", error([](auto& m) { m.primitives[0].type = 77; }));
  EXPECT_NE("", error([](auto& m) { m.primitive_poses = {pose_at(1), pose_at(2)}; }));
  EXPECT_NE("", error([](auto& m) { m.mesh_poses = {pose_at(1), pose_at(2)}; }));
  EXPECT_NE("", error([](auto& m) { m.mesh_poses = {geometry_msgs::Pose()}; }));  // a quaternion of zeros
  EXPECT_NE("", error([](auto& m) { m.meshes[0].triangles.clear(); }));
  EXPECT_NE("", error([](auto& m) { m.meshes[0].triangles.resize(100'001); }));
  EXPECT_NE(std::string::npos, error([](auto& m) {
                                 m.meshes[0].triangles[1].vertex_indices[2] = 4;
                               }).find("vertex index 4, of 4"));
}

}  // namespace
}  // namespace extperfc::ros_convert
