#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>

#include "extperfc/base/error.hpp"

namespace extperfc {

/// Writes a file as a whole or not at all: `write` fills a neighbour (`<file>.<process>.part`) that then
/// takes the file's name, so a reader meets the old content or the new. The stream is binary and speaks the
/// classic locale. kFailed names the file and the reason (no such folder, no permission, disk full); the
/// neighbour is removed then.
[[nodiscard]] Result<void> write_file_atomically(const std::filesystem::path& file,
                                                 const std::function<void(std::ostream&)>& write);

/// The same with this text. Makes the file's folder when it is not there.
[[nodiscard]] Result<void> write_text_atomically(const std::filesystem::path& file, const std::string& text);

}  // namespace extperfc
