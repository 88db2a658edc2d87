#pragma once

#include <cstdint>
#include <memory>
#include <queue>
#include <utility>
#include <vector>

#include "extperfc/navigate/global_planner.hpp"

namespace extperfc::benchmark {

/// Plain Dijkstra over eight neighbours of the inflated grid, as navfn searches: the same cell costs, no
/// check of the footprint, no smoothing, arrays over the whole map. Ends at the goal.
class DijkstraPlanner : public navigate::GlobalPlanner {
 public:
  explicit DijkstraPlanner(double cost_per_cost) : cost_per_cost_(cost_per_cost) {}
  [[nodiscard]] navigate::NavResult<navigate::Path> plan(const navigate::CostGrid& costs,
                                                         const navigate::Footprint& footprint,
                                                         const navigate::PlanRequest& request) override;

 private:
  double cost_per_cost_;
  std::vector<float> length_;
  std::vector<std::int32_t> parent_;
};

/// OMPL's RRT* over x, y and yaw with the exact footprint, stopped after `time_s`.
[[nodiscard]] std::unique_ptr<navigate::GlobalPlanner> make_rrt_star(double time_s);

}  // namespace extperfc::benchmark
