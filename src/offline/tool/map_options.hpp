#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/mapping/mapper.hpp"
#include "extperfc/offline/recording.hpp"

namespace extperfc::offline::tool {

/// What the command line of extperfc-map says.
struct MapOptions {
  std::filesystem::path recording;
  RecordingOptions reading;
  mapping::MapperParams params;
  std::filesystem::path out;
  std::optional<std::filesystem::path> relations;
  std::optional<std::filesystem::path> session;  ///< to go on from
  std::optional<std::filesystem::path> gridmap;  ///< MRPT's files, too
  std::optional<std::filesystem::path> simplemap;
  std::size_t most_scans{std::numeric_limits<std::size_t>::max()};
  bool use_odometry{true};
  bool json{false};
  bool quiet{false};
  bool help{false};
};

/// Errors are for the user: what does not fit, and what would.
[[nodiscard]] Result<MapOptions> read_map_options(const std::vector<std::string>& words);

[[nodiscard]] std::string map_help();

}  // namespace extperfc::offline::tool
