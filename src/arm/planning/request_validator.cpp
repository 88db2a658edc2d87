#include "arm/planning/request_validator.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace extperfc::arm::planning {

namespace {

constexpr double kPi = 3.14159265358979323846;

void demand(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

/// The joint farthest outside, by at least `slack_rad`.
std::optional<Eigen::Index> outside(const JointLimits& limits, const JointVector& state, double slack_rad) {
  Eigen::Index worst = 0;
  const double excess = (state - limits.upper).cwiseMax(limits.lower - state).maxCoeff(&worst);
  if (excess > slack_rad) return worst;
  return std::nullopt;
}

std::string text(const char* what, const CollisionModel& model, const JointLimits& limits,
                 const JointVector& state, Eigen::Index joint) {
  std::ostringstream message;
  message << what << ": " << model.joint_names()[joint] << " is at " << state[joint]
          << " rad, its limits are " << limits.lower[joint] << " to " << limits.upper[joint];
  return message.str();
}

std::string text(const char* what, const Contact& contact) {
  return std::string(what) + ": " + contact.first + " touches " + contact.second;
}

/// Looks at the states of a request; says what is wrong with them.
class RequestValidator {
 public:
  RequestValidator(CollisionChecker& checker, const JointLimits& limits, const PlannerParams& params)
      : checker_(checker), limits_(limits), params_(params) {}

  std::optional<PlanResult> shape(const PlanRequest& request) const {
    const auto fits = [this](const JointVector& state) {
      return state.size() == limits_.lower.size() && state.allFinite();
    };
    if (!fits(request.start))
      return failed(PlanCode::kInvalidRequest, "the start needs " + joints() + " finite joint values");
    if (request.goals.empty()) return failed(PlanCode::kInvalidRequest, "no goal was given");
    for (std::size_t g = 0; g < request.goals.size(); ++g)
      if (!fits(request.goals[g]))
        return failed(PlanCode::kInvalidRequest,
                      "goal " + std::to_string(g) + " needs " + joints() + " finite joint values");
    return std::nullopt;
  }

  std::optional<PlanResult> start(const PlanRequest& request, Checked* checked) const {
    if (const auto joint = outside(limits_, request.start, params_.limit_repair_rad))
      return failed(PlanCode::kStartOutsideLimits,
                    text("start outside the limits", checker_.model(), limits_, request.start, *joint));
    checked->start = request.start.cwiseMax(limits_.lower).cwiseMin(limits_.upper);
    if (!checker_.is_free(checked->start))
      return failed(PlanCode::kStartInCollision, text("start in collision", collision(checked->start)));
    return std::nullopt;
  }

  std::optional<PlanResult> goals(const PlanRequest& request, Checked* checked) const {
    auto refusal = failed(PlanCode::kGoalOutsideLimits, "");
    const std::vector<bool> free = checker_.are_free(request.goals);
    for (std::size_t g = 0; g < request.goals.size(); ++g) {
      const auto& goal = request.goals[g];
      if (const auto joint = outside(limits_, goal, 0.0)) {
        if (refusal.message.empty())
          refusal.message = text("goal outside the limits", checker_.model(), limits_, goal, *joint);
      } else if (!free[g]) {
        const auto contact = collision(goal);
        refusal = failed(PlanCode::kGoalInCollision, text("goal in collision", contact));
      } else {
        checked->goals.push_back(goal);
        checked->goal_indices.push_back(static_cast<int>(g));
      }
    }
    if (checked->goals.empty()) return refusal;
    return std::nullopt;
  }

 private:
  [[nodiscard]] std::string joints() const { return std::to_string(limits_.lower.size()); }

  [[nodiscard]] Contact collision(const JointVector& state) const {
    if (auto contact = checker_.contact(state)) return *contact;
    return checker_.nearest(state).value();  // not in contact, but too near to be proven free
  }

  CollisionChecker& checker_;
  const JointLimits& limits_;
  const PlannerParams& params_;
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

std::optional<PlanResult> check_request(CollisionChecker& checker, const JointLimits& limits,
                                        const PlannerParams& params, const PlanRequest& request,
                                        Checked& checked) {
  const RequestValidator gate(checker, limits, params);
  if (auto refusal = gate.shape(request)) return refusal;
  if (auto refusal = gate.start(request, &checked)) return refusal;
  return gate.goals(request, &checked);
}

}  // namespace extperfc::arm::planning
