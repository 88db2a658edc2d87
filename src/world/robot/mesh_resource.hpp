#pragma once

#include <filesystem>
#include <string>

#include "extperfc/base/error.hpp"

namespace extperfc {

/// The file that a mesh's URI names: `package://extperfc/<path>` lies below `resource_root`. Errors: another
/// kind of URI, a path that leaves the folder, a file that is missing or is not a binary STL file.
[[nodiscard]] Result<std::filesystem::path> find_mesh(const std::string& uri,
                                                      const std::filesystem::path& resource_root);

}  // namespace extperfc
