#include "simulate/render/stl.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

namespace extperfc::simulate::render {

namespace {

using Eigen::Vector3f;
using Face = std::array<Vector3f, 3>;

constexpr std::size_t kHeaderBytes = 80;
constexpr std::size_t kFaceBytes = 50;
constexpr std::size_t kMaxFaces = 2'000'000;
constexpr float kCreaseCosine = 0.819F;  // 35 degrees

Result<std::vector<char>> read_bytes(const std::filesystem::path& path) {
  std::error_code problem;
  const auto size = std::filesystem::file_size(path, problem);
  std::ifstream file(path, std::ios::binary);
  if (problem || !file)
    return fail(ErrorCode::kNotFound, "mesh " + path.string() + " cannot be read; does the file exist?");
  if (size > kHeaderBytes + 4 + kFaceBytes * kMaxFaces)
    return fail(ErrorCode::kUnsupported, "mesh " + path.string() + " has more than " +
                                             std::to_string(kMaxFaces) + " triangles; simplify it");
  return std::vector<char>(std::istreambuf_iterator<char>(file), {});
}

std::uint32_t face_count(const std::vector<char>& bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kHeaderBytes, sizeof(count));  // little endian, as the format
  return count;
}

Result<std::vector<Face>> parse(const std::vector<char>& bytes, const MeshFile& file) {
  const auto corrupt = [&](const std::string& what) {
    return fail(ErrorCode::kCorrupt,
                "mesh " + file.path.string() + ": " + what + "; export it as binary STL again");
  };
  if (bytes.size() < kHeaderBytes + 4) return corrupt("too short for a binary STL");
  const std::size_t count = face_count(bytes);
  if (bytes.size() != kHeaderBytes + 4 + kFaceBytes * count)
    return corrupt("its length of " + std::to_string(bytes.size()) + " bytes does not fit the " +
                   std::to_string(count) + " triangles that its header names (or it is a text STL)");
  if (count == 0) return corrupt("it has no triangles");
  std::vector<Face> faces(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::array<float, 9> values{};
    std::memcpy(values.data(), bytes.data() + kHeaderBytes + 4 + kFaceBytes * i + 12, sizeof(values));
    for (std::size_t k = 0; k < 3; ++k)
      faces[i][k] = Vector3f(values[3 * k], values[3 * k + 1], values[3 * k + 2])
                        .cwiseProduct(file.scale.cast<float>());
    for (const auto& corner : faces[i])
      if (!corner.allFinite())
        return corrupt("triangle " + std::to_string(i) + " has a corner that is not finite");
  }
  return faces;
}

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

Result<Mesh> read_stl(const MeshFile& file, std::uint32_t surface) {
  const auto bytes = read_bytes(file.path);
  if (!bytes) return tl::unexpected(bytes.error());
  const auto faces = parse(*bytes, file);
  if (!faces) return tl::unexpected(faces.error());
  return build(*faces, surface);
}

}  // namespace extperfc::simulate::render
