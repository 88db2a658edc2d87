#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/offline/relations.hpp"

namespace extperfc::benchmark {

/// How a generated drive is recorded.
struct DriveParams {
  std::size_t rays{360};  ///< in a full revolution, from -180 degrees on
  double rate_hz{10};     ///< of the scans
  double longest_s{400};  ///< the recording ends then [s]
};

/// A recording: a CARMEN log, and relations between its scans from their true poses.
struct Recording {
  std::filesystem::path log;
  std::filesystem::path relations;  ///< empty: there are none
};

/// As offline::read_relations() reads them. Errors: the file cannot be written.
[[nodiscard]] Result<void> write_relations(const std::vector<offline::Relation>& relations,
                                           const std::filesystem::path& file);

/// A robot at 0.5 m/s and 0.6 rad/s through an office of 46 m x 30 m: the corridor around its middle, every
/// room, and the corridor again. Ranges up to 12 m with 1 cm of noise; odometry 2 % too long, with a veer and
/// noise. Seeded. Errors: the folder cannot be written.
[[nodiscard]] Result<Recording> record_office(const DriveParams& params, const std::filesystem::path& folder);

/// A robot at 1 m/s up and down a hall of 202 m x 202 m with pillars everywhere, one scan of 360 rays up to
/// 30 m each second, odometry nearly perfect: for the cost of a map of 4000 x 4000 cells, not for accuracy.
[[nodiscard]] Result<Recording> record_hall(const std::filesystem::path& folder);

}  // namespace extperfc::benchmark
