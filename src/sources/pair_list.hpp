#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc::sources {

/// Files of one moment.
struct Pair {
  double stamp_s{0};
  std::filesystem::path color;
  std::filesystem::path depth;  ///< empty: colour only
};

/// The pairs of a folder in playing order, at least one, every file existing. See open_pair_folder().
[[nodiscard]] Result<std::vector<Pair>> list_pairs(const std::filesystem::path& folder);

}  // namespace extperfc::sources
