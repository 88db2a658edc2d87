#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/world/shape.hpp"

namespace extperfc {

/// Triangles of a binary STL file. Errors: no such file, not a binary STL, a length that does not fit its
/// number of triangles, none or more than two million of them, a corner that is not finite.
[[nodiscard]] Result<std::vector<Triangle>> read_stl_triangles(const std::filesystem::path& path);

/// Triangles of a mesh, not yet scaled: those it has in memory, else those of its file. Errors: those of
/// read_stl_triangles(); none in memory, or a corner that is not finite.
[[nodiscard]] Result<std::shared_ptr<const std::vector<Triangle>>> triangles_of(const TriangleMesh& mesh);

}  // namespace extperfc
