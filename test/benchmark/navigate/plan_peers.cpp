#include "test/benchmark/navigate/plan_peers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <ompl/base/objectives/PathLengthOptimizationObjective.h>
#include <ompl/base/spaces/SE2StateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>

namespace extperfc::benchmark {

using navigate::CostGrid;
using navigate::Footprint;
using navigate::NavCode;
using navigate::NavResult;
using navigate::Path;
using navigate::PlanRequest;

NavResult<Path> DijkstraPlanner::plan(const CostGrid& costs, const Footprint& /*footprint*/,
                                      const PlanRequest& request) {
  const auto start = costs.cell_of({request.start.x, request.start.y});
  const auto goal = costs.cell_of({request.goal.x, request.goal.y});
  if (!start || !goal) return navigate::nav_fail(NavCode::kGoalOutside, "outside");
  length_.assign(costs.cells.size(), std::numeric_limits<float>::infinity());
  parent_.assign(costs.cells.size(), -1);
  using Entry = std::pair<float, std::int32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const auto source = static_cast<std::int32_t>(costs.index(*start));
  const auto target = static_cast<std::int32_t>(costs.index(*goal));
  const std::array<std::int32_t, 8> step{
      1, -1, costs.width, -costs.width, costs.width + 1, costs.width - 1, -costs.width + 1, -costs.width - 1};
  std::array<float, 256> weight{};
  for (std::size_t cost = 0; cost < navigate::kInscribedCost; ++cost)
    weight[cost] = static_cast<float>(1 + cost_per_cost_ * static_cast<double>(cost));
  length_[static_cast<std::size_t>(source)] = 0;
  open.emplace(0.0F, source);
  while (!open.empty()) {  // walls surround the map, so that no step leaves it
    const auto [reached, at] = open.top();
    open.pop();
    if (at == target) break;
    if (reached > length_[static_cast<std::size_t>(at)]) continue;
    for (std::size_t k = 0; k < step.size(); ++k) {
      const std::int32_t to = at + step[k];
      const float per_cell = weight[costs.cells[static_cast<std::size_t>(to)]];
      if (per_cell == 0) continue;
      const float next = reached + per_cell * (k < 4 ? 1.0F : 1.41421356F);
      if (!(next < length_[static_cast<std::size_t>(to)])) continue;
      length_[static_cast<std::size_t>(to)] = next;
      parent_[static_cast<std::size_t>(to)] = at;
      open.emplace(next, to);
    }
  }
  if (!std::isfinite(length_[static_cast<std::size_t>(target)]))
    return navigate::nav_fail(NavCode::kNoPath, "no path");
  Path path;
  for (std::int32_t at = target; at >= 0; at = parent_[static_cast<std::size_t>(at)]) {
    const Eigen::Vector2d middle = costs.middle_of({at % costs.width, at / costs.width});
    path.poses.push_back({middle.x(), middle.y(), 0});
  }
  std::reverse(path.poses.begin(), path.poses.end());
  return path;
}

namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

class RrtStar : public navigate::GlobalPlanner {
 public:
  explicit RrtStar(double time_s) : time_s_(time_s) { ompl::msg::setLogLevel(ompl::msg::LOG_NONE); }

  NavResult<Path> plan(const CostGrid& costs, const Footprint& footprint,
                       const PlanRequest& request) override {
    auto space = std::make_shared<ob::SE2StateSpace>();
    ob::RealVectorBounds bounds(2);
    for (unsigned axis = 0; axis < 2; ++axis) {
      bounds.setLow(axis, costs.origin_m[axis]);
      bounds.setHigh(axis,
                     costs.origin_m[axis] + costs.resolution_m * (axis == 0 ? costs.width : costs.height));
    }
    space->setBounds(bounds);
    og::SimpleSetup setup(space);
    setup.setStateValidityChecker([&](const ob::State* state) {
      const auto* pose = state->as<ob::SE2StateSpace::StateType>();
      return contact(costs, footprint, {pose->getX(), pose->getY(), pose->getYaw()}) ==
             navigate::Contact::kFree;
    });
    setup.getSpaceInformation()->setStateValidityCheckingResolution(costs.resolution_m /
                                                                    space->getMaximumExtent());
    ob::ScopedState<ob::SE2StateSpace> start(space);
    ob::ScopedState<ob::SE2StateSpace> goal(space);
    start->setXY(request.start.x, request.start.y);
    start->setYaw(request.start.yaw);
    goal->setXY(request.goal.x, request.goal.y);
    goal->setYaw(request.goal.yaw);
    setup.setStartAndGoalStates(start, goal, 0.1);
    auto planner = std::make_shared<og::RRTstar>(setup.getSpaceInformation());
    planner->setRange(3.0);
    setup.setPlanner(planner);
    if (setup.solve(time_s_) != ob::PlannerStatus::EXACT_SOLUTION)
      return navigate::nav_fail(NavCode::kPlanTimeout, "no path in time");
    Path path;
    for (const ob::State* state : setup.getSolutionPath().getStates()) {
      const auto* pose = state->as<ob::SE2StateSpace::StateType>();
      path.poses.push_back({pose->getX(), pose->getY(), pose->getYaw()});
    }
    return path;
  }

 private:
  double time_s_;
};

}  // namespace

std::unique_ptr<navigate::GlobalPlanner> make_rrt_star(double time_s) {
  return std::make_unique<RrtStar>(time_s);
}

}  // namespace extperfc::benchmark
