#pragma once

#include "extperfc/world/shape.hpp"

#include "simulate/render/mip_texture.hpp"

namespace extperfc::simulate {

/// Null for Texture::kNone. Made at the first call (some milliseconds) and kept; any thread. The same on
/// every machine but for rounding.
[[nodiscard]] const MipTexture* texture_of(Texture texture);

}  // namespace extperfc::simulate
