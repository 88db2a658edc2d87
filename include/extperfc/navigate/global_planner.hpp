#pragma once

#include <atomic>
#include <memory>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/nav_error.hpp"
#include "extperfc/navigate/path.hpp"
#include "extperfc/navigate/velocity.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

struct PlanRequest {
  Pose2 start;                               ///< of the base, in the grid's frame
  Pose2 goal;                                ///< the same
  double tolerance_m{0};                     ///< a goal that is blocked may be moved this far [m], >= 0
  const std::atomic<bool>* cancel{nullptr};  ///< true: plan() returns kCancelled within 50 ms
};

/// Interface of global planners (nav_core's BaseGlobalPlanner): a user's own is loaded by pluginlib. `plan`
/// is called by one thread at a time; the grid does not change meanwhile.
class GlobalPlanner {
 public:
  virtual ~GlobalPlanner() = default;
  /// A path whose every pose has Contact::kFree (kUnknown only where the planner allows unknown space), from
  /// the start to the goal or, with a tolerance, the nearest free pose about it. Errors: every 2xx code,
  /// kInvalidRequest for what is not finite, kCancelled.
  [[nodiscard]] virtual NavResult<Path> plan(const CostGrid& costs, const Footprint& footprint,
                                             const PlanRequest& request) = 0;
};

struct GridPlannerParams {
  bool allow_unknown{false};  ///< plan through unknown cells
  double neutral_cost{
      50};  ///< of a free cell, (0, 252]; smaller: farther from obstacles (global_planner's name)
  double cost_factor{3.0};              ///< multiplies cell costs, [0, 100] (global_planner's name)
  double default_tolerance_m{0.0};      ///< of requests without one, [0, 10]
  double max_time_s{5.0};               ///< kPlanTimeout afterwards, (0, 600]
  BaseKind base{BaseKind::kHolonomic};  ///< a differential base heads along its path
  double heading_weight{0.5};           ///< how much a holonomic base prefers to head along its path, [0, 1]
};

/// Least path cost on the grid (any angle, smoothed), then checked with the true footprint in SE(2) and
/// refined where the footprint has to turn to pass. Throws std::invalid_argument for parameters out of their
/// range.
[[nodiscard]] std::unique_ptr<GlobalPlanner> make_grid_planner(const GridPlannerParams& params);

}  // namespace extperfc::navigate
