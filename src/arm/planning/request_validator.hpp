#pragma once

#include <optional>
#include <string>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/motion_planner.hpp"

namespace extperfc::arm::planning {

/// Continuous joints get [-pi, pi].
[[nodiscard]] JointLimits bounded(JointLimits limits);

/// Throws std::invalid_argument for a number out of its range.
void demand_ranges(const PlannerParams& params);

/// What a request has after its states were looked at.
struct Checked {
  JointVector start;
  std::vector<JointVector> goals;
  std::vector<int> goal_indices;  ///< in the request
};

/// Fills `checked`, or says what is wrong with the request. O(goals) checks of states.
[[nodiscard]] std::optional<PlanResult> check_request(CollisionChecker& checker, const JointLimits& limits,
                                                      const PlannerParams& params, const PlanRequest& request,
                                                      Checked& checked);

[[nodiscard]] PlanResult failed(PlanCode code, std::string message);

}  // namespace extperfc::arm::planning
