#pragma once

#include <vector>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/local_planner.hpp"

namespace extperfc::navigate {

/// How a base stops: it reacts for `reaction_s` with the command, then brakes within its limits.
struct BrakingRules {
  VelocityLimits limits;
  double reaction_s{0.1};
};

/// Whether the footprint stays free from `pose` on when `command` is sent for dt_s and the base then brakes:
/// exact against the grid, and against people who go on walking. `trajectory` receives the poses.
class CommandCheck {
 public:
  CommandCheck(const CostGrid& costs, const Footprint& footprint, const LocalState& state,
               const BrakingRules& rules)
      : costs_(costs), footprint_(footprint), state_(state), rules_(rules) {}

  [[nodiscard]] bool free(const Twist2& current, const Twist2& command, double dt_s) const;

 private:
  [[nodiscard]] bool people_free(const Pose2& pose, double time_s, double speed_m_s) const;
  /// From the footprint at a pose to a point of the grid's frame [m]; 0 inside.
  [[nodiscard]] double gap(const Pose2& pose, const Eigen::Vector2d& at) const;

  const CostGrid& costs_;
  const Footprint& footprint_;
  const LocalState& state_;
  const BrakingRules& rules_;
};

/// From a point of the base's frame to the polygon [m]; 0 inside. O(corners).
[[nodiscard]] double distance_m(const Footprint& footprint, const Eigen::Vector2d& point_m);

}  // namespace extperfc::navigate
