#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "extperfc/mapping/mapper.hpp"
#include "extperfc/sources/scan_log.hpp"
#include "extperfc/world/trajectory.hpp"

namespace extperfc::offline {

struct MappingProgress {
  double fraction{0};    ///< of the file, [0, 1]
  std::size_t scans{0};  ///< so far
};

struct MappingOptions {
  bool use_odometry{true};
  std::size_t max_scans{std::numeric_limits<std::size_t>::max()};
  /// Called before each scan; false ends the mapping with the scans so far.
  std::function<bool(const MappingProgress&)> should_continue;
};

/// Cost of one scan [ms of CPU, all threads].
struct CpuPerScan {
  double mean{0};
  double p50{0};
  double p99{0};
  double max{0};
};

struct MappingResult {
  std::size_t scans{0};    ///< read from the recording
  std::size_t refused{0};  ///< of them, those that the mapper did not take
  std::size_t damaged{0};  ///< entries of the recording that could not be read
  std::size_t without_odometry{0};
  double recorded_s{0};  ///< from the smallest stamp to the largest
  double cpu_s{0};       ///< reading and mapping
  double wall_s{0};
  CpuPerScan cpu_ms;
  double odometry_m{0};                 ///< distance travelled by odometry
  bool interrupted{false};              ///< should_continue returned false
  std::string broken;                   ///< why the recording ended early; empty: it did not
  std::vector<std::string> complaints;  ///< the first of what was damaged or refused
  /// One pose for each scan that was read, in their order; a refused one follows odometry from the last
  /// before.
  Trajectory trajectory;
  std::vector<std::size_t> scan_index;  ///< of each pose: ScanRecord::index
  Pose2 base_T_scanner;                 ///< of the first scan
};

/// Feeds a recording to the mapper until it ends, and finishes the mapper.
[[nodiscard]] MappingResult map_recording(sources::ScanLog& log, mapping::Mapper& mapper,
                                          const MappingOptions& options = {});

/// The process's largest resident memory so far [MB = 10^6 bytes]; 0 where the system does not report it.
[[nodiscard]] double peak_memory_mb();

}  // namespace extperfc::offline
