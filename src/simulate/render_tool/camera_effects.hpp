#pragma once

#include <cstdint>
#include <vector>

#include "extperfc/base/rng.hpp"

namespace extperfc::simulate {

/// What lens, sensor and automatic exposure do to an image: brightness, contrast, white balance, saturation,
/// vignetting, blur of focus or motion, noise. In place; `rgb` has 3 bytes per pixel.
void apply_camera_effects(Rng& rng, std::vector<std::uint8_t>& rgb, int width, int height);

}  // namespace extperfc::simulate
