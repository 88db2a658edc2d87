#pragma once

#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/map/drive.hpp"
#include "test/benchmark/map/options.hpp"
#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

/// What is mapped: the Intel log where it is there, else a generated building.
struct Subject {
  std::string name;
  bool is_intel{false};
  Recording recording;
};

/// Accuracy, CPU time and memory by the number of particles, and how they grow with the map.
[[nodiscard]] Result<std::vector<Row>> log_rows(const Subject& subject, const MapOptions& options);
/// The first scans, against MRPT's rbpf-slam. Errors: the peer cannot be run.
[[nodiscard]] Result<std::vector<Row>> peer_rows(const Subject& subject, const MapOptions& options);
/// CPU by beams and rate in a generated building.
[[nodiscard]] Result<std::vector<Row>> rate_rows(const MapOptions& options);
/// map() on this recording and in a hall of 4000 x 4000 cells.
[[nodiscard]] Result<std::vector<Row>> map_call_rows(const Subject& subject, const MapOptions& options);

}  // namespace extperfc::benchmark
