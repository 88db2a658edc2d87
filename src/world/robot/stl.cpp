#include "extperfc/world/stl.hpp"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

#include "world/robot/stl_format.hpp"

namespace extperfc {
namespace {

constexpr std::size_t kNormalBytes = 12;
constexpr std::size_t kMaxTriangles = 2'000'000;

tl::unexpected<Error> corrupt(const std::filesystem::path& path, const std::string& what) {
  return fail(ErrorCode::kCorrupt, "mesh " + path.string() + ": " + what + "; export it as binary STL again");
}

Result<std::vector<char>> read_bytes(const std::filesystem::path& path) {
  std::error_code problem;
  const auto size = std::filesystem::file_size(path, problem);
  std::ifstream file(path, std::ios::binary);
  if (problem || !file)
    return fail(ErrorCode::kNotFound, "mesh " + path.string() + " cannot be read; does the file exist?");
  if (size > kStlHeaderBytes + kStlTriangleBytes * kMaxTriangles)
    return fail(ErrorCode::kUnsupported, "mesh " + path.string() + " has more than " +
                                             std::to_string(kMaxTriangles) + " triangles; simplify it");
  return std::vector<char>(std::istreambuf_iterator<char>(file), {});
}

Triangle triangle_at(const char* bytes) {
  std::array<float, 9> values{};  // little endian, as the format
  std::memcpy(values.data(), bytes + kNormalBytes, sizeof(values));
  Triangle triangle;
  for (std::size_t k = 0; k < 3; ++k) triangle[k] = {values[3 * k], values[3 * k + 1], values[3 * k + 2]};
  return triangle;
}

}  // namespace

Result<std::vector<Triangle>> read_stl_triangles(const std::filesystem::path& path) {
  const auto bytes = read_bytes(path);
  if (!bytes) return tl::unexpected(bytes.error());
  if (bytes->size() < kStlHeaderBytes) return corrupt(path, "too short for a binary STL");
  std::uint32_t count = 0;
  std::memcpy(&count, bytes->data() + kStlTextBytes, sizeof(count));
  if (bytes->size() != kStlHeaderBytes + kStlTriangleBytes * count)
    return corrupt(path, "its length of " + std::to_string(bytes->size()) + " bytes does not fit the " +
                             std::to_string(count) +
                             " triangles that its header names (or it is a text STL)");
  if (count == 0) return corrupt(path, "it has no triangles");
  std::vector<Triangle> triangles;
  triangles.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    triangles.push_back(triangle_at(bytes->data() + kStlHeaderBytes + kStlTriangleBytes * i));
    for (const auto& corner : triangles.back())
      if (!corner.allFinite())
        return corrupt(path, "triangle " + std::to_string(i) + " has a corner that is not finite");
  }
  return triangles;
}

Result<std::shared_ptr<const std::vector<Triangle>>> triangles_of(const TriangleMesh& mesh) {
  if (!mesh.triangles) {
    auto read = read_stl_triangles(mesh.path);
    if (!read) return tl::unexpected(read.error());
    return std::make_shared<const std::vector<Triangle>>(std::move(*read));
  }
  const auto wrong = [&](const char* what) {
    return fail(ErrorCode::kInvalidArgument, "mesh " + mesh.path.string() + ": " + what);
  };
  if (mesh.triangles->empty()) return wrong("it has no triangles");
  for (const auto& triangle : *mesh.triangles)
    for (const auto& corner : triangle)
      if (!corner.allFinite()) return wrong("a corner is not finite");
  return mesh.triangles;
}

}  // namespace extperfc
