#pragma once

#include <filesystem>

#include "extperfc/base/error.hpp"

#include "world/pgm.hpp"

namespace extperfc {

/// Whether a file begins as PNG images do. False when it cannot be read.
[[nodiscard]] bool is_png(const std::filesystem::path& file);

/// Reads a PNG image of any kind as 8-bit grey: the mean of the colours. Errors name the file and the reason.
[[nodiscard]] Result<GreyImage> read_png(const std::filesystem::path& file);

}  // namespace extperfc
