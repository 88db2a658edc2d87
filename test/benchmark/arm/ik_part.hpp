#pragma once

#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

/// Inverse kinematics of Baxter's left arm on random reachable poses, from mid-range: how many within 1 ms,
/// time of each, limits violated, against KDL's solvers with 5 ms on the first of the same poses. Times are
/// CPU times of the thread, so that other programs do not count. `quick`: a twentieth and a tenth of the
/// poses.
[[nodiscard]] Result<std::vector<Row>> ik_rows(bool quick);

}  // namespace extperfc::benchmark
