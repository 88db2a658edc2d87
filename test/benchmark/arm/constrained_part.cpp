#include "test/benchmark/arm/constrained_part.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

#include "extperfc/arm/constrained_planner.hpp"
#include "extperfc/base/running_stats.hpp"
#include "extperfc/base/stopwatch.hpp"

#include "test/benchmark/arm/constrained_peer.hpp"
#include "test/benchmark/arm/constrained_problems.hpp"

namespace extperfc::benchmark {

namespace {

using arm::CollisionChecker;
using arm::JointVector;

constexpr double kErrorGoalRad = 1e-4;

/// What one side did with the problems that it was given.
struct Tally {
  int asked{0};
  int solved{0};
  int hidden{0};       ///< paths on which Bullet finds a collision
  int holding{0};      ///< paths without one that keep the tool within kErrorGoalRad
  double tilt_rad{0};  ///< largest on any path
  std::vector<double> ms;

  [[nodiscard]] double percent(int of) const { return asked > 0 ? 100.0 * of / asked : 0.0; }
};

template <typename Look>
void along(const std::vector<JointVector>& path, double step_rad, Look&& look) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    const JointVector delta = path[i] - path[i - 1];
    const int steps = 1 + static_cast<int>(delta.norm() / step_rad);
    for (int s = 0; s <= steps; ++s)
      look(JointVector(path[i - 1] + delta * (static_cast<double>(s) / steps)));
  }
}

void count(Tally* tally, bool solved, double seconds, const std::vector<JointVector>& path,
           const LevelProblem& problem, CollisionChecker& exact, const ConstrainedOptions& options) {
  ++tally->asked;
  if (!solved) return;
  ++tally->solved;
  tally->ms.push_back(1e3 * seconds);
  double tilt = 0;
  bool touches = false;
  along(path, options.error_rad,
        [&](const JointVector& state) { tilt = std::max(tilt, tilt_rad(problem.model, state)); });
  along(path, options.recheck_rad,
        [&](const JointVector& state) { touches = touches || exact.contact(state).has_value(); });
  tally->tilt_rad = std::max(tally->tilt_rad, tilt);
  tally->hidden += touches ? 1 : 0;
  tally->holding += !touches && tilt <= kErrorGoalRad ? 1 : 0;
}

struct Outcome {
  int direct{0};    ///< solved by a straight walk along the manifold
  int straight{0};  ///< the straight segment in joint space would do
  Tally ours, atlas, projected;
  std::vector<double> ms_with_atlas, ms_with_projected;  ///< ours, where the peer found a path too
};

Result<void> run_problem(int index, const LevelProblem& problem, const ConstrainedOptions& options,
                         Outcome* outcome) {
  auto checker = CollisionChecker::make(problem.model, problem.world);
  if (!checker) return tl::unexpected(checker.error());
  auto exact = CollisionChecker::make(problem.model, problem.world, {1e-3, false});
  if (!exact) return tl::unexpected(exact.error());
  arm::ConstrainedPlannerParams params;
  params.timeout_s = options.timeout_s;
  const CpuStopwatch watch;
  const auto plan =
      arm::ConstrainedPlanner(*checker, problem.constraint, params).plan({problem.start, {problem.goal}, {}});
  const double seconds = watch.seconds();
  const bool solved = plan.code == arm::PlanCode::kSuccess;
  if (!solved) std::fprintf(stderr, "  problem %d: %s\n", index, plan.message.c_str());
  outcome->direct += solved && plan.states == 0 ? 1 : 0;
  outcome->straight += problem.constraint.segment_error(problem.start, problem.goal) <= kErrorGoalRad ? 1 : 0;
  count(&outcome->ours, solved, seconds, plan.waypoints, problem, *exact, options);
  if (index >= options.peer_count) return {};
  const auto atlas = plan_with_ompl(problem, *checker, PeerSpace::kAtlas, options.timeout_s);
  count(&outcome->atlas, atlas.solved, atlas.seconds, atlas.waypoints, problem, *exact, options);
  if (solved && atlas.solved) outcome->ms_with_atlas.push_back(1e3 * seconds);
  const auto projected = plan_with_ompl(problem, *checker, PeerSpace::kProjected, options.timeout_s);
  count(&outcome->projected, projected.solved, projected.seconds, projected.waypoints, problem, *exact,
        options);
  if (solved && projected.solved) outcome->ms_with_projected.push_back(1e3 * seconds);
  return {};
}

void add_rows(const std::string& name, const std::string& peer_name, Tally& ours, Tally& peer,
              std::vector<double>& ms_with_peer, std::vector<Row>* rows) {
  const auto add = [&](const char* metric, const char* unit, double own, double other) {
    rows->push_back({name, metric, unit, own, other, peer_name});
    return &rows->back();
  };
  Row* row = add("solved", "%", ours.percent(ours.solved), peer.percent(peer.solved));
  *row = at_least(*row, 99.0);
  add("solved, level to 1e-4 rad and without a collision", "%", ours.percent(ours.holding),
      peer.percent(peer.holding));
  row = add("plan and simplify, CPU, median", "ms", percentile(ours.ms, 0.5), percentile(peer.ms, 0.5));
  *row = at_most(*row, 40.0);
  add("the same where both found a path", "ms", percentile(ms_with_peer, 0.5), percentile(peer.ms, 0.5));
  add("plan and simplify, CPU, p95", "ms", percentile(ours.ms, 0.95), percentile(peer.ms, 0.95));
  row = add("largest tilt on the path", "rad", ours.tilt_rad, peer.tilt_rad);
  *row = at_most(*row, kErrorGoalRad);
  row = add("paths with a hidden collision", "", ours.hidden, peer.hidden);
  *row = at_most(*row, 0.0);
}

}  // namespace

Result<std::vector<Row>> constrained_rows(const ConstrainedOptions& options) {
  const auto problems = level_problems(options.seed, options.count);
  if (!problems) return tl::unexpected(problems.error());
  std::fprintf(stderr, "constrained, level tool\n");
  Outcome outcome;
  for (int p = 0; p < static_cast<int>(problems->size()); ++p)
    if (auto done = run_problem(p, (*problems)[static_cast<std::size_t>(p)], options, &outcome); !done)
      return tl::unexpected(done.error());
  const std::string name = "level tool, left arm";
  std::vector<Row> rows;
  rows.push_back(
      {name, "straight in joint space keeps it level", "%", outcome.ours.percent(outcome.straight)});
  rows.push_back({name, "straight along the manifold is free", "%", outcome.ours.percent(outcome.direct)});
  add_rows(name, "OMPL atlas, RRTConnect", outcome.ours, outcome.atlas, outcome.ms_with_atlas, &rows);
  add_rows(name, "OMPL projected, RRTConnect", outcome.ours, outcome.projected, outcome.ms_with_projected,
           &rows);
  return rows;
}

}  // namespace extperfc::benchmark
