// Triangles of shapes and files.

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "simulate/render/head_mesh.hpp"
#include "simulate/render/mesh.hpp"
#include "simulate/render/person_mesh.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::simulate {
namespace {

using Eigen::Vector3f;

/// Volume by the divergence theorem: right only when the mesh is closed and its triangles look outwards.
double volume(const Mesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles)
    sum += mesh.vertices[t.corners[0]].position.dot(
               mesh.vertices[t.corners[1]].position.cross(mesh.vertices[t.corners[2]].position)) /
           6.0;
  return sum;
}

/// `folds`: triangles that may look inwards, in the crease of a joint.
void expect_sound(const Mesh& mesh, int folds = 0) {
  int inwards = 0;
  ASSERT_FALSE(mesh.triangles.empty());
  for (const auto& v : mesh.vertices) ASSERT_NEAR(v.normal.norm(), 1.0F, 1e-4F);
  for (const auto& t : mesh.triangles) {
    const auto& a = mesh.vertices[t.corners[0]];
    const Vector3f n = (mesh.vertices[t.corners[1]].position - a.position)
                           .cross(mesh.vertices[t.corners[2]].position - a.position);
    Vector3f mean = Vector3f::Zero();
    for (const auto corner : t.corners) mean += mesh.vertices[corner].normal;
    inwards += n.dot(mean) > 0.0F ? 0 : 1;
  }
  EXPECT_LE(inwards, folds) << "normals and winding disagree";
}

Mesh mesh_of(const Geometry& geometry, const Material& material = {}) {
  return make_mesh(geometry, material, 0).value();
}

TEST(Mesh, ShapesAreClosedAndLookOutwards) {
  for (const double size : {0.02, 0.1, 1.0}) {
    const double s3 = size * size * size;
    const Mesh box = mesh_of(Box{{size, 2 * size, 3 * size}});
    expect_sound(box);
    EXPECT_NEAR(volume(box), 6 * s3, 1e-4 * s3);
    // n corners of radius r enclose n/2 sin(2 pi / n) r^2 instead of pi r^2; twice for a sphere.
    const double n = circle_corners(size);
    const double fraction = n / (2 * M_PI) * std::sin(2 * M_PI / n);
    const Mesh cylinder = mesh_of(Cylinder{size, size});
    expect_sound(cylinder);
    EXPECT_NEAR(volume(cylinder), M_PI * s3 * fraction, 1e-3 * s3);
    const Mesh cone = mesh_of(Cone{size, size});
    expect_sound(cone);
    EXPECT_NEAR(volume(cone), M_PI / 3 * s3 * fraction, 1e-3 * s3);
    const Mesh sphere = mesh_of(Sphere{size});
    expect_sound(sphere);
    EXPECT_LT(volume(sphere), 4 * M_PI / 3 * s3);
    EXPECT_GT(volume(sphere), 4 * M_PI / 3 * s3 * fraction * fraction * fraction);
  }
}

TEST(Mesh, TextureRepeatsAfterItsSize) {
  const Mesh box = mesh_of(Box{{2, 2, 2}}, {{1, 1, 1}, Texture::kTiles, 0.5F, 0});
  float u_max = 0;
  for (const auto& v : box.vertices) u_max = std::max(u_max, v.texture.x());
  EXPECT_FLOAT_EQ(u_max, 4.0F);
}

TEST(Mesh, AppendMovesAndRenumbers) {
  Mesh mesh = mesh_of(Box{{1, 1, 1}});
  Eigen::Isometry3f shift = Eigen::Isometry3f::Identity();
  shift.translation() = Vector3f(5, 0, 0);
  mesh.append(mesh_of(Box{{1, 1, 1}}), shift);
  EXPECT_NEAR(volume(mesh), 2.0, 1e-4);
}

TEST(Mesh, PersonStandsOnTheFloorAndIsOneMetreSeventy) {
  const Mesh person = make_person({0, 1, 2, 3, 4, 5}, face_features(7));
  expect_sound(person, 40);
  float low = 9;
  float high = 0;
  std::array<bool, 6> seen{};
  for (const auto& v : person.vertices) {
    low = std::min(low, v.position.z());
    high = std::max(high, v.position.z());
  }
  for (const auto& t : person.triangles) seen[t.surface] = true;
  EXPECT_NEAR(low, 0.0F, 0.03F);
  EXPECT_NEAR(high, 1.77F, 0.03F);
  for (const bool part : seen) EXPECT_TRUE(part);
  EXPECT_LT(person.triangles.size(), 12000U);
}

TEST(Mesh, HeadsOfAllSeedsAreClosedAndOfAHeadsSize) {
  for (int seed = 0; seed < 24; ++seed) {
    const Mesh head = make_head(HeadShape(face_features(seed)), 0);
    expect_sound(head, 60);
    EXPECT_GT(volume(head), 0.0030) << seed;  // [m^3]
    EXPECT_LT(volume(head), 0.0055) << seed;
  }
}

using Face = std::array<Vector3f, 3>;

class Stl : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& bytes) {
    const auto path = folder_.path() / "mesh.stl";
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  static std::string binary(const std::vector<Face>& faces) {
    std::string bytes(80, ' ');
    const auto count = static_cast<std::uint32_t>(faces.size());
    bytes.append(reinterpret_cast<const char*>(&count), sizeof(count));
    for (const auto& face : faces) {
      bytes.append(12, '\0');
      for (const auto& corner : face) bytes.append(reinterpret_cast<const char*>(corner.data()), 12);
      bytes.append(2, '\0');
    }
    return bytes;
  }
  static std::string error_of(const std::filesystem::path& path) {
    const auto mesh = make_mesh(TriangleMesh{path}, {}, 0);
    return mesh ? "" : std::string(to_string(mesh.error().code)) + ": " + mesh.error().message;
  }

  TemporaryFolder folder_;
  /// Two faces that share an edge, bent by `angle` about it.
  static std::vector<Face> bent(float angle) {
    const Vector3f up(0, std::cos(angle), std::sin(angle));
    return {{Vector3f(0, 0, 0), Vector3f(0, -1, 0), Vector3f(1, 0, 0)},
            {Vector3f(0, 0, 0), Vector3f(1, 0, 0), up}};
  }
};

TEST_F(Stl, GentleEdgesAreSmoothAndSharpOnesAreNot) {
  for (const bool sharp : {false, true}) {
    const auto mesh = make_mesh(TriangleMesh{write(binary(bent(sharp ? 0.8F : 0.4F)))}, {}, 0);
    ASSERT_TRUE(mesh) << mesh.error().message;
    ASSERT_EQ(mesh->triangles.size(), 2U);
    const Vector3f& first = mesh->vertices[0].normal;
    const Vector3f& second = mesh->vertices[3].normal;  // the same place in the other face
    EXPECT_EQ((first - second).norm() > 1e-3F, sharp);
  }
}

TEST_F(Stl, ScaleIsApplied) {
  TriangleMesh file{write(binary(bent(0.4F)))};
  file.scale = {2, 3, 4};
  const auto mesh = make_mesh(file, {}, 0);
  ASSERT_TRUE(mesh);
  EXPECT_FLOAT_EQ(mesh->vertices[2].position.x(), 2.0F);
  EXPECT_FLOAT_EQ(mesh->vertices[1].position.y(), -3.0F);
}

TEST_F(Stl, DamagedFilesAreNamedWithTheReason) {
  EXPECT_NE(error_of(folder_.path() / "none.stl").find("not_found"), std::string::npos);
  const std::string good = binary(bent(0.4F));
  for (const auto& bytes : {std::string(), std::string("solid text\nendsolid"),
                            good.substr(0, good.size() - 7), good + "x", binary({})}) {
    const std::string error = error_of(write(bytes));
    EXPECT_NE(error.find("corrupt"), std::string::npos) << error;
    EXPECT_NE(error.find("mesh.stl"), std::string::npos) << error;
  }
  auto faces = bent(0.4F);
  faces[1][2].x() = std::nanf("");
  EXPECT_NE(error_of(write(binary(faces))).find("triangle 1"), std::string::npos);
}

}  // namespace
}  // namespace extperfc::simulate
