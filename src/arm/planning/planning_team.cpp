#include "extperfc/arm/planning_team.hpp"

#include <string>
#include <utility>

#include "extperfc/base/demand.hpp"

#include "arm/planning/request_validator.hpp"
#include "arm/planning/shortcuts.hpp"
#include "arm/planning/team_work.hpp"
#include "arm/planning/termination.hpp"

namespace extperfc::arm {

namespace {

void demand_good(const PlanningTeamParams& params) {
  demand_ranges(params.planner);
  demand(!params.members.empty() && params.members.size() <= 16, "PlanningTeamParams::members: 1 to 16");
  demand(params.threads >= 1 && params.threads <= 8, "PlanningTeamParams::threads: 1 to 8");
  int others = 0;
  for (const auto& member : params.members) {
    demand_planner(member.planner, planner_names());
    others += is_ours(member) ? 0 : 1;
  }
  const int needed = others + (others < static_cast<int>(params.members.size()) ? 1 : 0);
  demand(params.threads >= needed || others == 0,
         "PlanningTeamParams::threads: these members need " + std::to_string(needed));
}

double cost_of(const PlanningTeamParams& params, const std::vector<JointVector>& waypoints) {
  return params.cost ? params.cost(waypoints) : path_length(waypoints);
}

TeamResult ended(PlanCode code, const std::string& message) {
  TeamResult result;
  result.plan = failed(code, message);
  return result;
}

void succeed(TeamResult& result, const Checked& checked, int goal, std::vector<JointVector> waypoints) {
  result.plan.code = PlanCode::kSuccess;
  result.plan.message.clear();
  result.plan.goal = checked.goal_indices[static_cast<std::size_t>(goal)];
  result.plan.length_rad = path_length(waypoints);
  result.plan.waypoints = std::move(waypoints);
}

TeamResult first_path(const TeamProblem& problem, CollisionChecker& checker, Termination& termination) {
  TeamResult result;
  FirstPath search(problem);
  auto winner = search.run([&] { return termination.over(); });
  result.plan.search_s = termination.seconds();
  result.plan.states = search.states();
  if (!winner) return result;
  const PlanningTeamParams& params = problem.params;
  Rng rng(params.members[static_cast<std::size_t>(winner->member)].seed);
  auto waypoints = shorten(checker, std::move(winner->found.waypoints), params.planner.shortcut_rounds, rng,
                           [&] { return termination.over(); });
  result.plan.shortcut_s = termination.seconds() - result.plan.search_s;
  result.member = winner->member;
  result.cost = cost_of(params, waypoints);
  succeed(result, problem.request, winner->found.goal, std::move(waypoints));
  return result;
}

TeamResult best_path(const TeamProblem& problem, int max_attempts, Termination& termination) {
  TeamResult result;
  BestPath search(problem, max_attempts);
  auto winner = search.run([&] { return termination.over(); });
  result.plan.search_s = termination.seconds();
  result.attempts = search.attempts();
  result.found = search.found();
  if (!winner) return result;
  result.member = winner->member;
  result.cost = winner->cost;
  succeed(result, problem.request, winner->goal, std::move(winner->waypoints));
  return result;
}

}  // namespace

PlanningTeam::PlanningTeam(CollisionChecker& checker, const PlanningTeamParams& params)
    : checker_(checker), params_(params), limits_(bounded(checker.model().limits())) {
  demand_good(params_);
}

TeamResult PlanningTeam::plan(const PlanRequest& request, const TeamEffort& effort) {
  demand(effort.timeout_s > 0, "TeamEffort::timeout_s: more than 0 s");
  demand(effort.max_attempts >= 1 && effort.max_attempts <= 1'000'000,
         "TeamEffort::max_attempts: 1 to 1,000,000");
  Termination termination(request, effort.timeout_s);
  CollisionChecker checker = checker_.clone();
  Checked checked;
  if (auto refusal = check_request(checker, limits_, params_.planner.limit_repair_rad, request, checked)) {
    TeamResult result;
    result.plan = std::move(*refusal);
    return result;
  }
  if (termination.cancelled()) return ended(PlanCode::kCancelled, "cancelled");
  const TeamProblem problem{checker_, limits_, params_, checked};
  TeamResult result;
  // Nothing is shorter than the straight path; a cost of the caller's may think otherwise.
  const bool straight_is_best = !effort.improve || !params_.cost;
  Search straight(checker, limits_, params_.planner);
  auto found = straight_is_best ? straight.straight(checked.start, checked.goals) : std::nullopt;
  if (found && (!effort.improve || checked.goals.size() == 1)) {
    result.cost = cost_of(params_, found->waypoints);
    succeed(result, checked, found->goal, std::move(found->waypoints));
    return result;
  }
  result = effort.improve ? best_path(problem, effort.max_attempts, termination)
                          : first_path(problem, checker, termination);
  if (termination.code() == PlanCode::kCancelled) return ended(PlanCode::kCancelled, "cancelled");
  if (result.plan.code == PlanCode::kSuccess) return result;
  result.plan.code = PlanCode::kTimeout;
  result.plan.message = termination.message(params_.planner.max_states) + " of each member";
  return result;
}

}  // namespace extperfc::arm
