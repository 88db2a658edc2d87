#pragma once

#include <cstdint>

#include "extperfc/base/error.hpp"
#include "extperfc/world/shape.hpp"

#include "simulate/render/mesh.hpp"

namespace extperfc::simulate {

/// Binary STL. Normals are smooth except across edges of more than 35 degrees; the texture is mapped from the
/// nearest side of a box, in metres. Errors: those of read_stl_triangles().
[[nodiscard]] Result<Mesh> read_stl(const TriangleMesh& file, std::uint32_t surface);

}  // namespace extperfc::simulate
