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

namespace extperfc::offline {

/// Command line of extperfc-map.
struct MapOptions {
  std::filesystem::path recording;  ///< empty: only sessions are merged
  RecordingOptions reading;
  mapping::MapperParams params;
  std::filesystem::path out;
  std::optional<std::filesystem::path> relations;
  std::optional<std::filesystem::path> session;  ///< to resume from
  std::optional<Pose2> start_pose;               ///< of the robot in that session's map
  std::vector<std::filesystem::path> merged;     ///< sessions to add
  std::optional<std::filesystem::path> gridmap;  ///< MRPT's files, too
  std::optional<std::filesystem::path> simplemap;
  std::size_t max_scans{std::numeric_limits<std::size_t>::max()};
  bool use_odometry{true};
  bool json{false};
  bool quiet{false};
  bool help{false};
};

/// Errors are for the user: the wrong argument, and valid ones.
[[nodiscard]] Result<MapOptions> read_map_options(const std::vector<std::string>& tokens);

[[nodiscard]] std::string map_help();

}  // namespace extperfc::offline
