#include "simulate/bodies/stl.hpp"

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

namespace extperfc::simulate {
namespace {

constexpr std::size_t kHeaderBytes = 80;
constexpr std::size_t kTriangleBytes = 50;  // normal, three corners, attribute

Result<std::vector<Eigen::Vector3d>> damaged(const std::filesystem::path& path, const std::string& why) {
  return fail(ErrorCode::kCorrupt,
              "mesh " + path.string() + ": " + why + ": write it as a binary STL file with finite corners");
}

}  // namespace

Result<std::vector<Eigen::Vector3d>> read_stl_corners(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return fail(ErrorCode::kNotFound, "mesh " + path.string() + ": no such file: check its path");
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::uint32_t triangles = 0;
  if (bytes.size() < kHeaderBytes + sizeof(triangles)) return damaged(path, "too short");
  std::memcpy(&triangles, bytes.data() + kHeaderBytes, sizeof(triangles));
  const std::size_t start = kHeaderBytes + sizeof(triangles);
  if (triangles == 0 || bytes.size() < start + kTriangleBytes * triangles)
    return damaged(path, "the number of triangles does not fit the file's length");
  std::vector<Eigen::Vector3d> corners;
  corners.reserve(3 * static_cast<std::size_t>(triangles));
  for (std::size_t i = 0; i < triangles; ++i) {
    std::array<float, 12> values{};
    std::memcpy(values.data(), bytes.data() + start + i * kTriangleBytes, sizeof(values));
    for (int corner = 1; corner <= 3; ++corner)
      corners.emplace_back(values[3 * corner], values[3 * corner + 1], values[3 * corner + 2]);
    if (!corners.back().allFinite() || !corners[corners.size() - 2].allFinite() ||
        !corners[corners.size() - 3].allFinite())
      return damaged(path, "a corner is not finite");
  }
  return corners;
}

}  // namespace extperfc::simulate
