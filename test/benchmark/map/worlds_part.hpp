#pragma once

#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/map/options.hpp"
#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

/// Generated buildings of every kind, each drive in a separate process: rows per kind. Takes minutes.
[[nodiscard]] Result<std::vector<Row>> world_rows(const MapOptions& options);

/// Drives of 1.9 km (kLongGrid), with their CPU time and memory. Takes minutes for each.
[[nodiscard]] Result<std::vector<Row>> long_rows(const MapOptions& options);

/// The other side, in the new process; an exit code. The tokens are a kind and a seed, "carried" for a robot
/// that is carried over a tenth of its path, and a file for a table of the drive. Figures:
///   scans, path_m, loops, scan_mean_ms, scan_p99_ms (Mapper::add alone, CPU), cpu_s (of the whole drive, the
///   searches included), peak_mb, pairs (of poses that see each other again), bad_pairs (off by more than
///   0.5 m), and with pairs: pair_error_m (mean);
///   end_error_m (of the last pose as seen from the first), end_sigma_m (what the mapper says of it).
int run_world_part(const std::vector<std::string>& tokens);

}  // namespace extperfc::benchmark
