#include "world/robot/mesh_resource.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <system_error>

#include "world/robot/stl_format.hpp"

namespace extperfc {

namespace {

namespace fs = std::filesystem;

constexpr const char* kScheme = "package://extperfc/";

/// Number of triangles that the header states (little-endian).
std::uint32_t stated_triangles(std::ifstream& stl) {
  std::array<unsigned char, kStlHeaderBytes> header{};
  stl.read(reinterpret_cast<char*>(header.data()), header.size());
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < 4; ++i) count |= std::uint32_t{header[kStlTextBytes + i]} << (8 * i);
  return count;
}

Result<void> check_stl(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(file, error);
  std::ifstream stl(file, std::ios::binary);
  if (error || !stl)
    return fail(ErrorCode::kNotFound, "mesh " + file.string() + " is missing or cannot be read");
  const std::uint32_t triangles = bytes < kStlHeaderBytes ? 0 : stated_triangles(stl);
  if (triangles == 0 || bytes != kStlHeaderBytes + triangles * kStlTriangleBytes)
    return fail(ErrorCode::kCorrupt,
                "mesh " + file.string() + " is not a binary STL file with triangles: export it as one");
  return {};
}

}  // namespace

Result<fs::path> find_mesh(const std::string& uri, const fs::path& resource_root) {
  if (uri.rfind(kScheme, 0) != 0)
    return fail(ErrorCode::kUnsupported,
                "mesh '" + uri + "' does not start with " + kScheme + ": put it into this package");
  const fs::path relative = uri.substr(std::string(kScheme).size());
  const bool leaves = std::any_of(relative.begin(), relative.end(), [](const auto& p) { return p == ".."; });
  if (leaves || relative.is_absolute())
    return fail(ErrorCode::kInvalidArgument, "mesh '" + uri + "' leaves the package: write it without '..'");
  const fs::path file = resource_root / relative;
  if (const auto checked = check_stl(file); !checked) return tl::unexpected<Error>(checked.error());
  return file;
}

}  // namespace extperfc
