#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc {

/// The value is the bytes of a pixel.
enum class PngLayout { kGrey = 1, kGreyAlpha = 2, kRgb = 3 };

/// Pixels row by row, top row first.
struct PngPixels {
  std::size_t width{0};
  std::size_t height{0};
  PngLayout layout{PngLayout::kGrey};
  const std::uint8_t* bytes{nullptr};  ///< width * height pixels
};

/// Writes a PNG image of 8 bits a channel, as a whole or not at all. Errors name the file and the reason.
[[nodiscard]] Result<void> write_png(const PngPixels& pixels, const std::filesystem::path& file);

}  // namespace extperfc
