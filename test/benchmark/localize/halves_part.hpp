#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

struct HalvesOptions {
  std::filesystem::path logs;          ///< folder of the recordings
  std::filesystem::path trajectories;  ///< folder of NAME.tum; empty: our mapper's results
  std::vector<std::string> names{"intel", "mit-csail", "fr079"};
  std::uint64_t first_seed{1};  ///< of the odometry's errors
  int seeds{3};
  std::size_t starts{10};   ///< of global localization, each direction
  std::size_t kidnaps{10};  ///< each direction, driving and standing
};

/// Localization of every half of every log in a map of the other half. Logs that are not there are reported
/// and left out.
[[nodiscard]] Result<std::vector<Row>> halves_rows(const HalvesOptions& options);

}  // namespace extperfc::benchmark
