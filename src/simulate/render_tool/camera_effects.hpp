#pragma once

#include <cstdint>
#include <vector>

#include "extperfc/base/rng.hpp"

namespace extperfc::simulate {

/// How far an image may be from a good one: the usual, or poor lenses, exposure, white balance and light.
enum class CameraQuality { kUsual, kPoor };

/// What lens, sensor and automatic exposure do to an image: brightness, contrast, white balance, saturation,
/// vignetting, blur of focus or motion, noise. In place; `rgb` has 3 bytes per pixel.
void apply_camera_effects(Rng& rng, std::vector<std::uint8_t>& rgb, int width, int height,
                          CameraQuality quality = CameraQuality::kUsual);

}  // namespace extperfc::simulate
