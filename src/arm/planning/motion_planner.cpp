#include "extperfc/arm/motion_planner.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "extperfc/base/stopwatch.hpp"

#include "arm/planning/ompl_search.hpp"
#include "arm/planning/search.hpp"
#include "arm/planning/shortcuts.hpp"

namespace extperfc::arm {

namespace {

constexpr const char* kOwnPlanner = "rrt_connect";
constexpr double kPi = 3.14159265358979323846;

void demand(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

JointLimits bounded(JointLimits limits) {
  for (Eigen::Index j = 0; j < limits.lower.size(); ++j) {
    if (!std::isfinite(limits.lower[j])) limits.lower[j] = -kPi;
    if (!std::isfinite(limits.upper[j])) limits.upper[j] = kPi;
  }
  return limits;
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

PlanResult failed(PlanCode code, std::string message) {
  PlanResult result;
  result.code = code;
  result.message = std::move(message);
  return result;
}

/// What a request has after its states were looked at.
struct Checked {
  JointVector start;
  std::vector<JointVector> goals;
  std::vector<int> goal_indices;  ///< in the request
};

/// Looks at the states of a request; says what is wrong with them.
class Gate {
 public:
  Gate(CollisionChecker& checker, const JointLimits& limits, const PlannerParams& params)
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
    if (const auto contact = collision(checked->start))
      return failed(PlanCode::kStartInCollision, text("start in collision", *contact));
    return std::nullopt;
  }

  std::optional<PlanResult> goals(const PlanRequest& request, Checked* checked) const {
    auto refusal = failed(PlanCode::kGoalOutsideLimits, "");
    for (std::size_t g = 0; g < request.goals.size(); ++g) {
      const auto& goal = request.goals[g];
      if (const auto joint = outside(limits_, goal, 0.0)) {
        if (refusal.message.empty())
          refusal.message = text("goal outside the limits", checker_.model(), limits_, goal, *joint);
      } else if (const auto contact = collision(goal)) {
        refusal = failed(PlanCode::kGoalInCollision, text("goal in collision", *contact));
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

  [[nodiscard]] std::optional<Contact> collision(const JointVector& state) const {
    if (checker_.is_free(state)) return std::nullopt;
    if (auto contact = checker_.contact(state)) return contact;
    return Contact{"something", "something else", 0.0};  // a gap too small to prove
  }

  CollisionChecker& checker_;
  const JointLimits& limits_;
  const PlannerParams& params_;
};

}  // namespace

const char* to_string(PlanCode code) {
  switch (code) {
    case PlanCode::kSuccess:
      return "success";
    case PlanCode::kInvalidRequest:
      return "invalid_request";
    case PlanCode::kStartOutsideLimits:
      return "start_outside_limits";
    case PlanCode::kStartInCollision:
      return "start_in_collision";
    case PlanCode::kGoalOutsideLimits:
      return "goal_outside_limits";
    case PlanCode::kGoalInCollision:
      return "goal_in_collision";
    case PlanCode::kTimeout:
      return "timeout";
    case PlanCode::kCancelled:
      return "cancelled";
  }
  return "unknown";
}

const std::vector<std::string>& planner_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result{kOwnPlanner};
    const auto& others = planning::ompl_planners();
    result.insert(result.end(), others.begin(), others.end());
    return result;
  }();
  return names;
}

double path_length(const std::vector<JointVector>& waypoints) {
  double length = 0;
  for (std::size_t i = 1; i < waypoints.size(); ++i) length += (waypoints[i] - waypoints[i - 1]).norm();
  return length;
}

MotionPlanner::MotionPlanner(CollisionChecker& checker, const PlannerParams& params)
    : checker_(checker), params_(params), limits_(bounded(checker.model().limits())) {
  const auto& names = planner_names();
  if (std::find(names.begin(), names.end(), params.planner) == names.end())
    throw std::invalid_argument("PlannerParams::planner: '" + params.planner +
                                "' is none of planner_names()");
  demand(params.range_rad >= 0.05 && params.range_rad <= 3.0, "PlannerParams::range_rad: 0.05 to 3 rad");
  demand(params.timeout_s > 0.0, "PlannerParams::timeout_s: more than 0 s");
  demand(params.max_states >= 2 && params.max_states <= 10'000'000,
         "PlannerParams::max_states: 2 to 10,000,000");
  demand(params.shortcut_rounds >= 0 && params.shortcut_rounds <= 10'000,
         "PlannerParams::shortcut_rounds: 0 to 10,000");
  demand(params.limit_repair_rad >= 0.0 && params.limit_repair_rad <= 0.2,
         "PlannerParams::limit_repair_rad: 0 to 0.2 rad");
}

std::optional<planning::Found> MotionPlanner::search(const JointVector& start,
                                                     const std::vector<JointVector>& goals,
                                                     const std::function<bool()>& stop, int* states) {
  if (params_.planner != kOwnPlanner)
    return planning::ompl_search(checker_, limits_, params_, start, goals, stop);
  planning::Search own(checker_, limits_, params_);
  auto found = own.run(start, goals, stop);
  *states = own.states();
  return found;
}

PlanResult MotionPlanner::plan(const PlanRequest& request) {
  const Gate gate(checker_, limits_, params_);
  Checked checked;
  if (auto refusal = gate.shape(request)) return *refusal;
  if (auto refusal = gate.start(request, &checked)) return *refusal;
  if (auto refusal = gate.goals(request, &checked)) return *refusal;

  bool cancelled = false;
  const Stopwatch watch;
  const auto asked_to_stop = [&] {
    return cancelled = cancelled || (request.cancelled && request.cancelled());
  };
  const auto stop = [&] { return asked_to_stop() || watch.seconds() > params_.timeout_s; };
  PlanResult result;
  auto found = search(checked.start, checked.goals, stop, &result.states);
  result.search_s = watch.seconds();
  if (!found) {
    result.code = cancelled ? PlanCode::kCancelled : PlanCode::kTimeout;
    result.message = cancelled ? "cancelled"
                               : "no path within " + std::to_string(params_.timeout_s) + " s and " +
                                     std::to_string(params_.max_states) + " states";
    return result;
  }
  Rng rng(params_.seed);
  result.waypoints =
      planning::shorten(checker_, std::move(found->waypoints), params_.shortcut_rounds, rng, asked_to_stop);
  result.shortcut_s = watch.seconds() - result.search_s;
  if (cancelled) return failed(PlanCode::kCancelled, "cancelled");
  result.code = PlanCode::kSuccess;
  result.goal = checked.goal_indices[found->goal];
  result.length_rad = path_length(result.waypoints);
  return result;
}

}  // namespace extperfc::arm
