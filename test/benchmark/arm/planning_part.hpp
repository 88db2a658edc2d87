#pragma once

#include <filesystem>
#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

struct PlanningOptions {
  std::filesystem::path problems;  ///< folder; every .txt file in it holds problems for both arms
  int count{600};                  ///< of each file's problems, the first ones
  int seeds{3};                    ///< plans for each problem, by seeds 1, 2, ...
  int peer_count{60};              ///< of the problems, for the peer, by one seed
  double peer_timeout_s{5.0};
  double recheck_rad{0.0005};      ///< distance of the states at which Bullet looks for hidden collisions
  double trajectory_step_s{1e-3};  ///< the same along timed trajectories
};

/// For every file of problems the left arm alone (the right one stands at its start), then both arms:
/// success, time of search and simplification, hidden collisions on the paths, against OMPL's RRTConnect on
/// Bullet; and hidden collisions on the trajectories that the whole pipeline makes of the same problems.
[[nodiscard]] Result<std::vector<Row>> planning_rows(const PlanningOptions& options);

}  // namespace extperfc::benchmark
