#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "extperfc/world/image_view.hpp"

namespace extperfc::depth {

/// Depth [m] of a pixel of a depth image; 0 or not finite: no measurement.
[[nodiscard]] inline double depth_at(const ImageView& depth, int x, int y) {
  const std::uint8_t* const row = depth.row(y);
  if (depth.format == PixelFormat::kDepth16Mm) {
    std::uint16_t mm = 0;
    std::memcpy(&mm, row + static_cast<std::size_t>(x) * sizeof mm, sizeof mm);
    return 0.001 * mm;
  }
  float metres = 0;
  std::memcpy(&metres, row + static_cast<std::size_t>(x) * sizeof metres, sizeof metres);
  return metres;
}

}  // namespace extperfc::depth
