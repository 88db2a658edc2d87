#include "simulate/render/stl.hpp"

#include <array>
#include <map>
#include <vector>

#include "extperfc/world/stl.hpp"

namespace extperfc::simulate {

namespace {

using Eigen::Vector3f;
using Face = extperfc::Triangle;

constexpr float kCreaseCosine = 0.819F;  // 35 degrees

/// Twice the area times the unit normal.
Vector3f area_normal(const Face& face) {
  return (face[1] - face[0]).cross(face[2] - face[0]);
}

using Corner = std::array<float, 3>;

Corner key(const Vector3f& p) {
  return {p.x() + 0.0F, p.y() + 0.0F, p.z() + 0.0F};  // -0 and 0 are one place
}

using FacesAtCorner = std::map<Corner, std::vector<std::size_t>>;

FacesAtCorner faces_at_corners(const std::vector<Face>& faces) {
  FacesAtCorner at;
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (const auto& corner : faces[i]) at[key(corner)].push_back(i);
  return at;
}

/// Area-weighted mean of the normals around a corner that differ by less than the crease angle.
Vector3f smooth_normal(const std::vector<Vector3f>& normals, const std::vector<std::size_t>& around,
                       const Vector3f& own) {
  Vector3f sum = Vector3f::Zero();
  for (const auto i : around)
    if (normals[i].dot(own) >= kCreaseCosine * normals[i].norm() * own.norm()) sum += normals[i];
  const float length = sum.norm();
  return length > 0 ? Vector3f(sum / length) : Vector3f::UnitZ();
}

/// Side of a box that the face looks to most, unrolled.
Eigen::Vector2f box_texture(const Vector3f& p, const Vector3f& normal) {
  const Vector3f a = normal.cwiseAbs();
  if (a.z() >= a.x() && a.z() >= a.y()) return {p.x(), p.y()};
  return a.x() >= a.y() ? Eigen::Vector2f(p.y(), p.z()) : Eigen::Vector2f(p.x(), p.z());
}

Mesh build(const std::vector<Face>& faces, std::uint32_t surface) {
  std::vector<Vector3f> normals;
  normals.reserve(faces.size());
  for (const auto& face : faces) normals.push_back(area_normal(face));
  const auto around = faces_at_corners(faces);
  Mesh mesh;
  mesh.vertices.reserve(3 * faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const auto& corner : faces[i])
      mesh.vertices.push_back({corner, smooth_normal(normals, around.at(key(corner)), normals[i]),
                               box_texture(corner, normals[i])});
    mesh.triangles.push_back({{first, first + 1, first + 2}, surface});
  }
  return mesh;
}

}  // namespace

Result<Mesh> read_stl(const TriangleMesh& file, std::uint32_t surface) {
  const auto unscaled = triangles_of(file);
  if (!unscaled) return tl::unexpected(unscaled.error());
  std::vector<Face> faces = **unscaled;
  for (auto& face : faces)
    for (auto& corner : face) corner = corner.cwiseProduct(file.scale.cast<float>()).eval();
  return build(faces, surface);
}

}  // namespace extperfc::simulate
