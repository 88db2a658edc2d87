#pragma once

#include "simulate/render/head_shape.hpp"
#include "simulate/render/mesh.hpp"

namespace extperfc::simulate {

/// The head without ears, in the person's frame, about 4,800 triangles; texture coordinates are those of
/// make_face_texture().
[[nodiscard]] Mesh make_head(const HeadShape& head, std::uint32_t surface);

}  // namespace extperfc::simulate
