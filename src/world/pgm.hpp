#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc {

/// Larger maps are taken for damaged files.
constexpr std::size_t kMaxMapCells = std::size_t{1} << 28;

/// A grey image, top row first.
struct GreyImage {
  std::size_t width{0};             ///< pixels
  std::size_t height{0};            ///< pixels
  unsigned largest{255};            ///< the value of white, [1, 65535]
  std::string bytes;                ///< one byte a pixel, two (high byte first) where `largest` is above 255
  std::vector<bool> transparent{};  ///< of each pixel; empty: none is

  /// In [0, largest].
  [[nodiscard]] unsigned at(std::size_t x, std::size_t y) const;
  [[nodiscard]] bool is_transparent(std::size_t x, std::size_t y) const {
    return !transparent.empty() && transparent[y * width + x];
  }
};

/// Reads a PGM image, binary (P5) or text (P2). Errors name the file and what is wrong: no such file,
/// another image format, more than 2^28 pixels, fewer pixels than announced.
[[nodiscard]] Result<GreyImage> read_pgm(const std::filesystem::path& file);

}  // namespace extperfc
