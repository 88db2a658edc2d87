#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/map/child.hpp"
#include "test/benchmark/map/drive.hpp"

namespace extperfc::benchmark {

/// One run of the mapper over a recording.
struct LogRun {
  Recording recording;
  int particles{30};
  std::uint64_t seed{1};
  std::size_t scans{0};        ///< at most
  double map_every_s{0};       ///< of the recording, map() is called; 0: only at the end
  double linear_update_m{0};   ///< 0: the mapper's own
  bool rotation_counts{true};  ///< rotations make key frames too
};

/// The run in a separate process. Figures:
///   scans, cpu_s (reading and mapping), scan_mean_ms, scan_p99_ms, scan_max_ms (Mapper::add alone, CPU),
///   first_quarter_ms, last_quarter_ms (means), key_frames, loops, seconds (of the recording),
///   base_mb (before the first scan), peak_mb (with the map drawn), explored_m2, map_cells,
///   map_max_ms, map_last_median_ms (calls of map(), CPU: the worst; the median of the last quarter),
///   map_calls, and with relations those of add_score().
[[nodiscard]] Result<Figures> run_log(const LogRun& run);

/// The other side of run_log(), in the new process; an exit code.
int run_log_part(const std::vector<std::string>& tokens);

}  // namespace extperfc::benchmark
