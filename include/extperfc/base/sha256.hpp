#pragma once

#include <filesystem>
#include <string>

#include "extperfc/base/error.hpp"

namespace extperfc {

/// SHA-256 of a file's content as 64 lower-case hexadecimal digits. Reads in blocks, so the size does not
/// matter. Errors: kNotFound when the file cannot be opened, kFailed when reading breaks off.
[[nodiscard]] Result<std::string> sha256_of_file(const std::filesystem::path& file);

}  // namespace extperfc
