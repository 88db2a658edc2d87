#pragma once

#include <vector>

#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

/// What the time parameterization of random paths of a seven-joint arm costs (CPU time), how much longer or
/// shorter the motion is than one that stops at every waypoint, and what remains of the limits at 1 kHz.
/// `quick`: fewer paths.
[[nodiscard]] std::vector<Row> trajectory_rows(bool quick);

}  // namespace extperfc::benchmark
