#pragma once

#include <cstdint>
#include <vector>

#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

struct ControlOptions {
  bool quick{false};
  std::uint64_t first_seed{501};  ///< of the generated buildings
};

/// Time of control cycles and of the last-moment stop, in a building that is driven through.
void measure_control(const ControlOptions& options, std::vector<Row>& rows);

/// Closed loops in generated buildings, holonomic and differential, with and without people, against the
/// dynamic window approach on the same routes.
void measure_drives(const ControlOptions& options, std::vector<Row>& rows);

}  // namespace extperfc::benchmark
