#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/arm/constrained_planner.hpp"

#include "arm/constrained/cbirrt.hpp"

namespace extperfc::arm::constrained {

/// What a request has after its states were looked at.
struct Checked {
  JointVector start;
  States goals;
  std::vector<int> goal_indices;  ///< in the request
};

[[nodiscard]] ConstrainedPlanResult refused(PlanCode code, std::string message);

/// Looks at the states of a request; says what is wrong with them.
class RequestValidator {
 public:
  /// All of them must outlive it.
  RequestValidator(CollisionChecker& checker, const PathConstraint& constraint, const JointLimits& limits,
                   const ConstrainedPlannerParams& params)
      : checker_(checker), constraint_(constraint), limits_(limits), params_(params) {}

  [[nodiscard]] std::optional<ConstrainedPlanResult> shape(const PlanRequest& request) const;
  [[nodiscard]] std::optional<ConstrainedPlanResult> start(const PlanRequest& request,
                                                           Checked* checked) const;
  /// Refuses only when every goal is of no use; the refusal is about the last one.
  [[nodiscard]] std::optional<ConstrainedPlanResult> goals(const PlanRequest& request,
                                                           Checked* checked) const;

 private:
  [[nodiscard]] std::optional<ConstrainedPlanResult> off_limits(const JointVector& state, double slack_rad,
                                                                const char* what, PlanCode code) const;
  [[nodiscard]] std::optional<ConstrainedPlanResult> violated(const JointVector& state,
                                                              const char* what) const;
  [[nodiscard]] std::optional<ConstrainedPlanResult> collision(const JointVector& state, const char* what,
                                                               PlanCode code) const;

  CollisionChecker& checker_;
  const PathConstraint& constraint_;
  const JointLimits& limits_;
  const ConstrainedPlannerParams& params_;
};

/// Straight along the manifold to a goal, the nearest first.
[[nodiscard]] std::optional<Found> direct(Manifold& manifold, const JointVector& start, const States& goals,
                                          const std::function<bool()>& stop);

}  // namespace extperfc::arm::constrained
