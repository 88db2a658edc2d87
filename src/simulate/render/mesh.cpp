#include "simulate/render/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "extperfc/base/math.hpp"

#include "simulate/render/stl.hpp"

namespace extperfc::simulate {

namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

/// A rectangle from its corner along two edges; the texture starts at the corner.
void add_face(Mesh& mesh, const Vector3f& corner, const Vector3f& right, const Vector3f& up, bool rotated,
              std::uint32_t surface) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  const Vector3f normal = right.cross(up).normalized();
  for (int i = 0; i < 4; ++i) {
    const float a = i == 1 || i == 2 ? 1.0F : 0.0F;
    const float b = i >= 2 ? 1.0F : 0.0F;
    Vector2f texture(a * right.norm(), b * up.norm());
    if (rotated) std::swap(texture.x(), texture.y());
    mesh.vertices.push_back({corner + a * right + b * up, normal, texture});
  }
  mesh.triangles.push_back({{first, first + 1, first + 2}, surface});
  mesh.triangles.push_back({{first, first + 2, first + 3}, surface});
}

Mesh make(const Box& box, const Material& material, std::uint32_t surface) {
  Mesh mesh;
  const Vector3f h = 0.5F * box.size_m.cast<float>();
  const Vector3f x(2 * h.x(), 0, 0);
  const Vector3f y(0, 2 * h.y(), 0);
  const Vector3f z(0, 0, 2 * h.z());
  const auto add = [&](const Vector3f& corner, const Vector3f& right, const Vector3f& up) {
    const bool grain_up = material.texture == Texture::kWood && up.norm() > right.norm();
    add_face(mesh, corner, right, up, grain_up, surface);
  };
  add({-h.x(), -h.y(), h.z()}, x, y);
  add({-h.x(), h.y(), -h.z()}, x, -y);
  if (material.texture == Texture::kBooks) {
    // From above one sees the books' colours, not their backs.
    const bool along_x = h.x() >= h.y();
    for (auto& vertex : mesh.vertices)
      vertex.texture = {vertex.position[along_x ? 0 : 1] + (along_x ? h.x() : h.y()),
                        0.18F * material.texture_size_m};
  }
  add({-h.x(), -h.y(), -h.z()}, x, z);
  add({h.x(), h.y(), -h.z()}, -x, z);
  add({h.x(), -h.y(), -h.z()}, y, z);
  add({-h.x(), h.y(), -h.z()}, -y, z);
  return mesh;
}

/// A ring of the surface of revolution about z. The normal is (radial, along z).
struct Ring {
  float radius, z;
  Vector2f normal;
  float along;  ///< length of surface up to here [m]
};

void add_ring(Mesh& mesh, const Ring& ring, int corners, float texture_radius) {
  for (int i = 0; i <= corners; ++i) {
    const float angle = kTwoPiF * static_cast<float>(i) / static_cast<float>(corners);
    const float c = std::cos(angle);
    const float s = std::sin(angle);
    mesh.vertices.push_back({{ring.radius * c, ring.radius * s, ring.z},
                             {ring.normal.x() * c, ring.normal.x() * s, ring.normal.y()},
                             {angle * texture_radius, ring.along}});
  }
}

/// Sweeps rings from the bottom upwards.
void add_revolution(Mesh& mesh, const std::vector<Ring>& rings, int corners, float texture_radius,
                    std::uint32_t surface) {
  const auto row = static_cast<std::uint32_t>(corners + 1);
  auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const auto& ring : rings) add_ring(mesh, ring, corners, texture_radius);
  for (std::size_t i = 1; i < rings.size(); ++i, first += row)
    join_rows(mesh, first, first + row, row, surface);
}

void add_disc(Mesh& mesh, float radius, float z, int corners, std::uint32_t surface) {
  const float up = z > 0 ? 1.0F : -1.0F;
  const auto centre = static_cast<std::uint32_t>(mesh.vertices.size());
  const Vector3f normal(0, 0, up);
  mesh.vertices.push_back({{0, 0, z}, normal, {radius, radius}});
  for (int i = 0; i <= corners; ++i) {
    const float angle = up * kTwoPiF * static_cast<float>(i) / static_cast<float>(corners);
    const Vector3f at(radius * std::cos(angle), radius * std::sin(angle), z);
    mesh.vertices.push_back({at, normal, {at.x() + radius, at.y() + radius}});
  }
  for (std::uint32_t i = 1; i <= static_cast<std::uint32_t>(corners); ++i)
    mesh.triangles.push_back({{centre, centre + i, centre + i + 1}, surface});
}

Mesh make(const Cylinder& cylinder, const Material& /*material*/, std::uint32_t surface) {
  Mesh mesh;
  const auto radius = static_cast<float>(cylinder.radius_m);
  const auto half = 0.5F * static_cast<float>(cylinder.length_m);
  const int corners = circle_corners(cylinder.radius_m);
  add_revolution(mesh, {{radius, -half, {1, 0}, 0}, {radius, half, {1, 0}, 2 * half}}, corners, radius,
                 surface);
  add_disc(mesh, radius, half, corners, surface);
  add_disc(mesh, radius, -half, corners, surface);
  return mesh;
}

Mesh make(const Cone& cone, const Material& /*material*/, std::uint32_t surface) {
  Mesh mesh;
  const auto radius = static_cast<float>(cone.radius_m);
  const auto height = static_cast<float>(cone.height_m);
  const float side = std::hypot(radius, height);
  const Vector2f normal = Vector2f(height, radius) / side;
  const int corners = circle_corners(cone.radius_m);
  // Several rings: a long thin triangle interpolates normals badly near the tip.
  std::vector<Ring> rings;
  for (const float t : {0.0F, 0.4F, 0.7F, 0.9F, 1.0F})
    rings.push_back({radius * (1 - t), height * (t - 0.5F), normal, side * t});
  add_revolution(mesh, rings, corners, 0.5F * radius, surface);
  add_disc(mesh, radius, -0.5F * height, corners, surface);
  return mesh;
}

Mesh make(const Sphere& sphere, const Material& /*material*/, std::uint32_t surface) {
  Mesh mesh;
  const auto radius = static_cast<float>(sphere.radius_m);
  const int corners = circle_corners(sphere.radius_m);
  const int rows = corners / 2;
  std::vector<Ring> rings;
  for (int i = 0; i <= rows; ++i) {
    const float polar = 0.5F * kTwoPiF * static_cast<float>(i) / static_cast<float>(rows);
    const Vector2f normal(std::sin(polar), -std::cos(polar));
    rings.push_back({radius * normal.x(), radius * normal.y(), normal, radius * polar});
  }
  add_revolution(mesh, rings, corners, radius, surface);
  return mesh;
}

Result<Mesh> make(const TriangleMesh& file, const Material& /*material*/, std::uint32_t surface) {
  return read_stl(file, surface);
}

bool is_sliver(const Mesh& mesh, const MeshTriangle& triangle) {
  const Vector3f& a = mesh.vertices[triangle.corners[0]].position;
  const Vector3f ab = mesh.vertices[triangle.corners[1]].position - a;
  const Vector3f ac = mesh.vertices[triangle.corners[2]].position - a;
  const float longest2 = std::max(ab.squaredNorm(), ac.squaredNorm());
  return ab.cross(ac).squaredNorm() <= 1e-10F * longest2 * longest2;
}

}  // namespace

void Mesh::drop_slivers() {
  triangles.erase(std::remove_if(triangles.begin(), triangles.end(),
                                 [&](const MeshTriangle& t) { return is_sliver(*this, t); }),
                  triangles.end());
}

void Mesh::append(const Mesh& other, const Eigen::Isometry3f& this_T_other) {
  const auto offset = static_cast<std::uint32_t>(vertices.size());
  for (const auto& vertex : other.vertices)
    vertices.push_back(
        {this_T_other * vertex.position, this_T_other.linear() * vertex.normal, vertex.texture});
  for (auto triangle : other.triangles) {
    for (auto& corner : triangle.corners) corner += offset;
    triangles.push_back(triangle);
  }
}

Result<Mesh> make_mesh(const Geometry& geometry, const Material& material, std::uint32_t surface) {
  auto mesh =
      std::visit([&](const auto& shape) -> Result<Mesh> { return make(shape, material, surface); }, geometry);
  if (!mesh) return mesh;
  const float size = material.texture_size_m > 1e-4F ? material.texture_size_m : 1.0F;
  for (auto& vertex : mesh->vertices) vertex.texture /= size;
  mesh->drop_slivers();
  return mesh;
}

int circle_corners(double radius_m) {
  // A quarter of a millimetre between arc and chord, within limits.
  const double sagitta_m = 0.00025;
  const double half_angle = std::sqrt(2.0 * sagitta_m / std::max(radius_m, 1e-3));
  return 4 * std::clamp(static_cast<int>(std::ceil(kPi / half_angle / 4.0)), 4, 18);
}

void join_rows(Mesh& mesh, std::uint32_t first, std::uint32_t second, std::uint32_t row_length,
               std::uint32_t surface) {
  for (std::uint32_t i = 0; i + 1 < row_length; ++i) {
    mesh.triangles.push_back({{first + i, first + i + 1, second + i + 1}, surface});
    mesh.triangles.push_back({{first + i, second + i + 1, second + i}, surface});
  }
}

}  // namespace extperfc::simulate
