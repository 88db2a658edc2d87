#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "extperfc/arm/cartesian_path.hpp"

namespace extperfc::arm {

/// What is accepted of an approach or a descent in tight places [m].
[[nodiscard]] inline double shortened_m(double distance_m) {
  return std::min(distance_m, std::max(0.02, 0.5 * distance_m));
}

/// Group states of a straight collision-free path of the tip. Searches briefly, because many candidates are
/// tried.
[[nodiscard]] inline std::optional<std::vector<JointVector>> straight_path(CollisionChecker& checker,
                                                                           const ArmChain& chain,
                                                                           const JointVector& from,
                                                                           const Pose& root_T_tip) {
  CartesianParams params;
  params.max_attempts = 4;
  params.timeout_s = 0.1;
  auto planner = CartesianPlanner::make(checker, chain, params);
  if (!planner) return std::nullopt;
  auto path = planner->plan({from, {root_T_tip}, {}});
  if (path.end != CartesianEnd::kComplete) return std::nullopt;
  return std::move(path.waypoints);
}

}  // namespace extperfc::arm
