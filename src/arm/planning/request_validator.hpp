#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/motion_planner.hpp"

namespace extperfc::arm {

/// Continuous joints get [-pi, pi].
[[nodiscard]] JointLimits bounded(JointLimits limits);

/// Throws std::invalid_argument for a number out of its range.
void demand_ranges(const PlannerParams& params);
/// Throws std::invalid_argument for a planner that is not one of `names`.
void demand_planner(const std::string& planner, const std::vector<std::string>& names);

/// What a state breaks beside limits and obstacles.
struct Violation {
  int constraint{-1};  ///< its index
  std::string message;
};
using FindViolation = std::function<std::optional<Violation>(const JointVector&)>;

/// What a request has after its states were looked at.
struct Checked {
  JointVector start;
  std::vector<JointVector> goals;
  std::vector<int> goal_indices;  ///< in the request
  int violated{-1};               ///< the constraint that the request was refused for
};

/// Fills `checked`, or says what is wrong with the request. Refuses the goals only when none can be used; of
/// their faults the one counts that was found by the last check. O(goals) checks of states.
[[nodiscard]] std::optional<PlanResult> check_request(CollisionChecker& checker, const JointLimits& limits,
                                                      double limit_repair_rad, const PlanRequest& request,
                                                      Checked& checked, const FindViolation& violation = {});

[[nodiscard]] PlanResult failed(PlanCode code, std::string message);

}  // namespace extperfc::arm
