#pragma once

#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/map/options.hpp"
#include "test/benchmark/map/subjects.hpp"
#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

/// Accuracy, CPU time and memory on every subject; of the first one also by the number of particles, and how
/// they grow with the map.
[[nodiscard]] Result<std::vector<Row>> log_rows(const std::vector<Subject>& subjects,
                                                const MapOptions& options);
/// Every subject's first scans, against MRPT's mappers and odometry alone. A peer that fails is a row without
/// its figures; one that is not installed is left out, and this says so.
[[nodiscard]] Result<std::vector<Row>> peer_rows(const std::vector<Subject>& subjects,
                                                 const MapOptions& options);
/// CPU by beams and rate in a generated building.
[[nodiscard]] Result<std::vector<Row>> rate_rows(const MapOptions& options);
/// map() on this recording and in a hall of 4000 x 4000 cells.
[[nodiscard]] Result<std::vector<Row>> map_call_rows(const Subject& subject, const MapOptions& options);

}  // namespace extperfc::benchmark
