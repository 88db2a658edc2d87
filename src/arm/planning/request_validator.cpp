#include "arm/planning/request_validator.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "extperfc/base/demand.hpp"
#include "extperfc/base/math.hpp"

#include "arm/collision/state_fault.hpp"

namespace extperfc::arm {

namespace {

/// Looks at the states of a request; says what is wrong with them.
class RequestValidator {
 public:
  RequestValidator(CollisionChecker& checker, const JointLimits& limits, double limit_repair_rad,
                   const FindViolation& violation, Checked& checked)
      : checker_(checker),
        limits_(limits),
        limit_repair_rad_(limit_repair_rad),
        violation_(violation),
        checked_(checked) {}

  std::optional<PlanResult> check_shape(const PlanRequest& request) const {
    const auto fits = [this](const JointVector& state) {
      return state.size() == limits_.lower.size() && state.allFinite();
    };
    const std::string needs = " needs " + std::to_string(limits_.lower.size()) + " finite joint values";
    if (!fits(request.start)) return failed(PlanCode::kInvalidRequest, "the start" + needs);
    if (request.goals.empty()) return failed(PlanCode::kInvalidRequest, "no goal was given");
    for (std::size_t g = 0; g < request.goals.size(); ++g)
      if (!fits(request.goals[g]))
        return failed(PlanCode::kInvalidRequest, "goal " + std::to_string(g) + needs);
    return std::nullopt;
  }

  std::optional<PlanResult> check_start(const JointVector& start) {
    if (const auto fault = outside_limits(checker_.model(), limits_, start, limit_repair_rad_, "start"))
      return failed(PlanCode::kStartOutsideLimits, fault->message);
    checked_.start = start.cwiseMax(limits_.lower).cwiseMin(limits_.upper);
    if (const auto violation = find_violation(checked_.start)) return refuse("start", *violation);
    if (checker_.is_free(checked_.start)) return std::nullopt;
    return failed(PlanCode::kStartInCollision, in_collision(checker_, checked_.start, "start").message);
  }

  std::optional<PlanResult> check_goals(const std::vector<JointVector>& goals) {
    std::optional<std::string> outside;
    std::optional<Violation> violated;
    const JointVector* touching = nullptr;
    const std::vector<bool> free = checker_.are_free(goals);
    for (std::size_t g = 0; g < goals.size(); ++g) {
      if (const auto fault = outside_limits(checker_.model(), limits_, goals[g], 0.0, "goal")) {
        if (!outside) outside = fault->message;
      } else if (auto violation = find_violation(goals[g])) {
        if (!violated) violated = std::move(violation);
      } else if (!free[g]) {
        if (touching == nullptr) touching = &goals[g];
      } else {
        checked_.goals.push_back(goals[g]);
        checked_.goal_indices.push_back(static_cast<int>(g));
      }
    }
    if (!checked_.goals.empty()) return std::nullopt;
    if (touching != nullptr)
      return failed(PlanCode::kGoalInCollision, in_collision(checker_, *touching, "goal").message);
    if (violated) return refuse("goal", *violated);
    return failed(PlanCode::kGoalOutsideLimits, *outside);
  }

 private:
  [[nodiscard]] std::optional<Violation> find_violation(const JointVector& state) const {
    return violation_ ? violation_(state) : std::nullopt;
  }

  PlanResult refuse(const std::string& what, const Violation& violation) {
    checked_.violated = violation.constraint;
    return failed(PlanCode::kInvalidRequest, what + " " + violation.message);
  }

  CollisionChecker& checker_;
  const JointLimits& limits_;
  double limit_repair_rad_;
  const FindViolation& violation_;
  Checked& checked_;
};

}  // namespace

JointLimits bounded(JointLimits limits) {
  for (Eigen::Index j = 0; j < limits.lower.size(); ++j) {
    if (!std::isfinite(limits.lower[j])) limits.lower[j] = -kPi;
    if (!std::isfinite(limits.upper[j])) limits.upper[j] = kPi;
  }
  return limits;
}

PlanResult failed(PlanCode code, std::string message) {
  PlanResult result;
  result.code = code;
  result.message = std::move(message);
  return result;
}

void demand_ranges(const PlannerParams& params) {
  demand(params.range_rad >= 0.05 && params.range_rad <= 3.0, "PlannerParams::range_rad: 0.05 to 3 rad");
  demand(params.timeout_s > 0.0, "PlannerParams::timeout_s: more than 0 s");
  demand(params.max_states >= 2 && params.max_states <= 10'000'000,
         "PlannerParams::max_states: 2 to 10,000,000");
  demand(params.shortcut_rounds >= 0 && params.shortcut_rounds <= 10'000,
         "PlannerParams::shortcut_rounds: 0 to 10,000");
  demand(params.limit_repair_rad >= 0.0 && params.limit_repair_rad <= 0.2,
         "PlannerParams::limit_repair_rad: 0 to 0.2 rad");
}

void demand_planner(const std::string& planner, const std::vector<std::string>& names) {
  if (std::find(names.begin(), names.end(), planner) != names.end()) return;
  std::string known;
  for (const auto& name : names) known += (known.empty() ? "" : ", ") + name;
  throw std::invalid_argument("there is no planner '" + planner + "': use one of " + known);
}

std::optional<PlanResult> check_request(CollisionChecker& checker, const JointLimits& limits,
                                        double limit_repair_rad, const PlanRequest& request, Checked& checked,
                                        const FindViolation& violation) {
  RequestValidator validator(checker, limits, limit_repair_rad, violation, checked);
  if (auto refusal = validator.check_shape(request)) return refusal;
  if (auto refusal = validator.check_start(request.start)) return refusal;
  return validator.check_goals(request.goals);
}

}  // namespace extperfc::arm
