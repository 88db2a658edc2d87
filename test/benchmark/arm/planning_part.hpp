#pragma once

#include <filesystem>
#include <vector>

#include "extperfc/base/error.hpp"

#include "report.hpp"

namespace extperfc::benchmark {

struct PlanningOptions {
  std::filesystem::path problems;  ///< file of problems for both arms
  int count{600};                  ///< of its problems, the first ones
  int peer_count{60};              ///< of those, for the peer
  double peer_timeout_s{5.0};
  double recheck_rad{0.002};  ///< distance of the states at which Bullet looks for hidden collisions
};

/// The left arm alone (the right one stands at its start), then both arms: success, time of search and
/// simplification, hidden collisions; against OMPL's RRTConnect on Bullet.
[[nodiscard]] Result<std::vector<Row>> planning_rows(const PlanningOptions& options);

}  // namespace extperfc::benchmark
