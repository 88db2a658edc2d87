#include "arm/planning_part.hpp"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/motion_planner.hpp"
#include "extperfc/base/running_stats.hpp"

#include "arm/peer_ompl.hpp"
#include "arm/problems.hpp"

namespace extperfc::benchmark {

namespace {

using arm::CollisionChecker;
using arm::JointVector;

/// What one side did with the problems that it was given.
struct Tally {
  int asked{0};
  int solved{0};
  int hidden{0};  ///< paths on which Bullet finds a collision
  std::vector<double> ms;

  [[nodiscard]] double solved_percent() const { return asked > 0 ? 100.0 * solved / asked : 0.0; }
};

struct Goals {
  double solved_percent, median_ms;
  std::optional<double> p95_ms;
  double timeout_s;
};

bool hides_a_collision(CollisionChecker& exact, const std::vector<JointVector>& path, double step_rad) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    const JointVector way = path[i] - path[i - 1];
    const int steps = 1 + static_cast<int>(way.norm() / step_rad);
    for (int s = 0; s <= steps; ++s)
      if (exact.contact(path[i - 1] + way * (static_cast<double>(s) / steps))) return true;
  }
  return false;
}

void count(Tally* tally, bool solved, double seconds, const std::vector<JointVector>& path,
           CollisionChecker& exact, double recheck_rad) {
  ++tally->asked;
  if (!solved) return;
  ++tally->solved;
  tally->ms.push_back(1e3 * seconds);
  if (hides_a_collision(exact, path, recheck_rad)) ++tally->hidden;
}

struct Group {
  const char* name;
  ArmGroup arms;
  Goals goals;
};

struct Outcome {
  int valid{0};
  Tally ours, ours_of_peer, peer;  ///< ours_of_peer: on the problems that the peer had too
};

Result<void> run_problem(const ArmProblem& problem, const Group& group, const PlanningOptions& options,
                         bool with_peer, Outcome* outcome) {
  auto checker = make_checker(problem, group.arms, {});
  if (!checker) return tl::unexpected(checker.error());
  auto exact = make_checker(problem, group.arms, {1e-3, false});
  if (!exact) return tl::unexpected(exact.error());
  const JointVector start = states_of(problem.start, group.arms);
  const JointVector goal = states_of(problem.goal, group.arms);
  if (exact->contact(start) || exact->contact(goal)) return {};
  ++outcome->valid;
  arm::PlannerParams params;
  params.timeout_s = group.goals.timeout_s;
  const auto plan = arm::MotionPlanner(*checker, params).plan({start, {goal}, {}});
  const bool solved = plan.code == arm::PlanCode::kSuccess;
  const double seconds = plan.search_s + plan.shortcut_s;
  count(&outcome->ours, solved, seconds, plan.waypoints, *exact, options.recheck_rad);
  if (!solved) std::fprintf(stderr, "  problem %d: %s\n", problem.index, plan.message.c_str());
  if (!with_peer) return {};
  count(&outcome->ours_of_peer, solved, seconds, plan.waypoints, *exact, options.recheck_rad);
  const auto peer = plan_with_ompl(*exact, start, goal, options.peer_timeout_s);
  count(&outcome->peer, peer.solved, peer.seconds, peer.waypoints, *exact, options.recheck_rad);
  return {};
}

std::vector<Row> rows_of(const Group& group, Outcome& outcome, int problems) {
  const std::string name = group.name;
  const std::string peer_name = "OMPL RRTConnect on Bullet, 1/64 rad";
  std::vector<Row> rows;
  rows.push_back({name, "valid problems", "", static_cast<double>(outcome.valid),
                  static_cast<double>(problems), "problems"});
  rows.push_back(
      at_least({name, "solved", "%", outcome.ours.solved_percent(), outcome.peer.solved_percent(), peer_name},
               group.goals.solved_percent));
  rows.push_back(at_most({name, "paths with a hidden collision", "", static_cast<double>(outcome.ours.hidden),
                          static_cast<double>(outcome.peer.hidden), peer_name},
                         0.0));
  const auto time = [&](const char* metric, double share) {
    rows.push_back({name, metric, "ms", percentile(outcome.ours.ms, share),
                    percentile(outcome.peer.ms, share), peer_name});
  };
  time("plan and simplify, median", 0.5);
  rows.back() = at_most(rows.back(), group.goals.median_ms);
  time("plan and simplify, p75", 0.75);
  time("plan and simplify, p95", 0.95);
  if (group.goals.p95_ms) rows.back() = at_most(rows.back(), *group.goals.p95_ms);
  rows.push_back({name, "the peer's problems: median", "ms", percentile(outcome.ours_of_peer.ms, 0.5),
                  percentile(outcome.peer.ms, 0.5), peer_name});
  return rows;
}

}  // namespace

Result<std::vector<Row>> planning_rows(const PlanningOptions& options) {
  auto problems = read_problems(options.problems);
  if (!problems) return tl::unexpected(problems.error());
  if (static_cast<int>(problems->size()) > options.count)
    problems->resize(static_cast<std::size_t>(options.count));
  std::vector<Row> rows;
  for (const Group& group : {Group{"left arm", ArmGroup::kLeft, {100.0, 3.0, 30.0, 3.0}},
                             Group{"both arms", ArmGroup::kBoth, {99.0, 10.0, std::nullopt, 3.0}}}) {
    std::fprintf(stderr, "planning, %s\n", group.name);
    Outcome outcome;
    for (std::size_t p = 0; p < problems->size(); ++p) {
      const bool with_peer = outcome.peer.asked < options.peer_count;
      if (auto done = run_problem((*problems)[p], group, options, with_peer, &outcome); !done)
        return tl::unexpected(done.error());
    }
    const auto of_group = rows_of(group, outcome, static_cast<int>(problems->size()));
    rows.insert(rows.end(), of_group.begin(), of_group.end());
  }
  return rows;
}

}  // namespace extperfc::benchmark
