#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"

namespace extperfc {

/// Corners of a triangle, counter-clockwise seen from outside [the file's unit].
using StlTriangle = std::array<Eigen::Vector3f, 3>;

/// Triangles of a binary STL file. Errors: no such file, not a binary STL, a length that does not fit its
/// number of triangles, none or more than two million of them, a corner that is not finite.
[[nodiscard]] Result<std::vector<StlTriangle>> read_stl_triangles(const std::filesystem::path& path);

}  // namespace extperfc
