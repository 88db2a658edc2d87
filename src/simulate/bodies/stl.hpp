#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"

namespace extperfc::simulate {

/// Corners of a binary STL file's triangles, three by three. Errors: no such file, not a binary STL, no
/// triangle, a corner that is not finite.
[[nodiscard]] Result<std::vector<Eigen::Vector3d>> read_stl_corners(const std::filesystem::path& path);

}  // namespace extperfc::simulate
