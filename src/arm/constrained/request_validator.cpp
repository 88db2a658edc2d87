#include "arm/constrained/request_validator.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <sstream>
#include <utility>

namespace extperfc::arm::constrained {

namespace {

constexpr std::array<const char*, 5> kKinds{"axis", "plane", "line", "orientation", "relative pose"};

/// Maximum length of a direct path, relative to the distance.
constexpr double kMaxDetour = 2.0;

}  // namespace

ConstrainedPlanResult refused(PlanCode code, std::string message) {
  ConstrainedPlanResult result;
  result.code = code;
  result.message = std::move(message);
  return result;
}

std::optional<ConstrainedPlanResult> RequestValidator::shape(const PlanRequest& request) const {
  const auto fits = [this](const JointVector& state) {
    return state.size() == limits_.lower.size() && state.allFinite();
  };
  const std::string needs = " needs " + std::to_string(limits_.lower.size()) + " finite joint values";
  if (!fits(request.start)) return refused(PlanCode::kInvalidRequest, "the start" + needs);
  if (request.goals.empty()) return refused(PlanCode::kInvalidRequest, "no goal was given");
  for (std::size_t g = 0; g < request.goals.size(); ++g)
    if (!fits(request.goals[g]))
      return refused(PlanCode::kInvalidRequest, "goal " + std::to_string(g) + needs);
  return std::nullopt;
}

std::optional<ConstrainedPlanResult> RequestValidator::off_limits(const JointVector& state, double slack_rad,
                                                                  const char* what, PlanCode code) const {
  Eigen::Index worst = 0;
  const double excess = (state - limits_.upper).cwiseMax(limits_.lower - state).maxCoeff(&worst);
  if (excess <= slack_rad) return std::nullopt;
  std::ostringstream message;
  message << what
          << " outside the limits: " << checker_.model().joint_names()[static_cast<std::size_t>(worst)]
          << " is at " << state[worst] << " rad, its limits are " << limits_.lower[worst] << " to "
          << limits_.upper[worst];
  return refused(code, message.str());
}

std::optional<ConstrainedPlanResult> RequestValidator::violated(const JointVector& state,
                                                                const char* what) const {
  for (int c = 0; c < static_cast<int>(constraint_.constraints().size()); ++c) {
    const double error = constraint_.error(state, c);
    if (error <= params_.tolerance) continue;
    const auto& constraint = constraint_.constraints()[static_cast<std::size_t>(c)];
    std::ostringstream message;
    message << what << " breaks constraint " << c << " ("
            << kKinds.at(static_cast<std::size_t>(constraint.kind)) << " of " << constraint.link << ") by "
            << error << ", " << params_.tolerance << " at most";
    auto result = refused(PlanCode::kInvalidRequest, message.str());
    result.violated = c;
    return result;
  }
  return std::nullopt;
}

std::optional<ConstrainedPlanResult> RequestValidator::collision(const JointVector& state, const char* what,
                                                                 PlanCode code) const {
  if (checker_.is_free(state)) return std::nullopt;
  const auto contact = checker_.contact(state);
  return refused(
      code, contact ? std::string(what) + " in collision: " + contact->first + " touches " + contact->second
                    : std::string(what) + " in collision: a gap too small to prove");
}

std::optional<ConstrainedPlanResult> RequestValidator::start(const PlanRequest& request,
                                                             Checked* checked) const {
  if (auto refusal =
          off_limits(request.start, params_.limit_repair_rad, "start", PlanCode::kStartOutsideLimits))
    return refusal;
  checked->start = request.start.cwiseMax(limits_.lower).cwiseMin(limits_.upper);
  if (auto refusal = violated(checked->start, "the start")) return refusal;
  return collision(checked->start, "start", PlanCode::kStartInCollision);
}

std::optional<ConstrainedPlanResult> RequestValidator::goals(const PlanRequest& request,
                                                             Checked* checked) const {
  std::optional<ConstrainedPlanResult> refusal;
  for (std::size_t g = 0; g < request.goals.size(); ++g) {
    const auto& goal = request.goals[g];
    auto wrong = off_limits(goal, 0.0, "goal", PlanCode::kGoalOutsideLimits);
    if (!wrong) wrong = violated(goal, "the goal");
    if (!wrong) wrong = collision(goal, "goal", PlanCode::kGoalInCollision);
    if (wrong) {
      refusal = std::move(wrong);
      continue;
    }
    checked->goals.push_back(goal);
    checked->goal_indices.push_back(static_cast<int>(g));
  }
  if (checked->goals.empty()) return refusal;
  return std::nullopt;
}

std::optional<Found> direct(Manifold& manifold, const JointVector& start, const States& goals,
                            const std::function<bool()>& stop) {
  std::vector<int> order(goals.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return (goals[a] - start).squaredNorm() < (goals[b] - start).squaredNorm();
  });
  for (const int goal : order) {
    const double max_length = kMaxDetour * (goals[goal] - start).norm();
    auto pieces = manifold.connect(start, goals[goal], max_length, stop);
    if (!pieces) continue;
    pieces->insert(pieces->begin(), start);
    return Found{*std::move(pieces), goal};
  }
  return std::nullopt;
}

}  // namespace extperfc::arm::constrained
