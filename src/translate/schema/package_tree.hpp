#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc::translate {

enum class DefinitionKind : unsigned char { kMessage, kService, kAction };
inline constexpr std::array<DefinitionKind, 3> kDefinitionKinds{
    DefinitionKind::kMessage, DefinitionKind::kService, DefinitionKind::kAction};
/// "msg", "srv" or "action": the folder and the suffix.
[[nodiscard]] const char* to_string(DefinitionKind kind);

struct DefinitionFile {
  DefinitionKind kind{DefinitionKind::kMessage};
  std::string type;  ///< "package/Name"
  std::filesystem::path path;
};

struct PackageTree {
  std::vector<DefinitionFile> files;  ///< ordered by path
  std::vector<std::string> problems;  ///< folders that cannot be read, names that are none
};

/// Every <package>/{msg,srv,action}/* at most `kTreeDepth` folders below `folder` (which may be a package
/// itself). Within a package no further packages are looked for. Links are followed, each folder once;
/// folders with CATKIN_IGNORE and hidden ones are left out.
[[nodiscard]] Result<PackageTree> find_packages(const std::filesystem::path& folder);
constexpr int kTreeDepth = 6;

/// A file of at most `max_bytes`; errors name the file.
[[nodiscard]] Result<std::string> read_text(const std::filesystem::path& file, std::size_t max_bytes);

}  // namespace extperfc::translate
