#pragma once

#include <cstdint>
#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

struct ConstrainedOptions {
  std::uint64_t seed{20};     ///< of the problems
  int count{100};             ///< problems
  int peer_count{100};        ///< of those, for the peers
  double timeout_s{5.0};      ///< wall time
  double recheck_rad{0.002};  ///< distance of the states at which Bullet looks for hidden collisions
  double error_rad{0.0005};   ///< distance of the states at which the tool's angle is measured
};

/// Baxter's left arm with its tool pointing straight down, over a table with random boxes: success, CPU time
/// of search and simplification, the tool's largest angle on the path, hidden collisions; against OMPL's
/// RRTConnect in its atlas and in its space of projected states.
[[nodiscard]] Result<std::vector<Row>> constrained_rows(const ConstrainedOptions& options);

}  // namespace extperfc::benchmark
