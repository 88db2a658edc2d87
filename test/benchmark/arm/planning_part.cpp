#include "test/benchmark/arm/planning_part.hpp"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/motion_pipeline.hpp"
#include "extperfc/arm/motion_planner.hpp"
#include "extperfc/arm/timed_path.hpp"
#include "extperfc/base/running_stats.hpp"

#include "test/benchmark/arm/judge.hpp"
#include "test/benchmark/arm/peer_ompl.hpp"
#include "test/benchmark/arm/problems.hpp"

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
  double solved_percent;
  std::optional<double> median_ms, p95_ms;
  double timeout_s;
};

void count(Tally* tally, bool solved, double seconds, bool hidden) {
  ++tally->asked;
  if (!solved) return;
  ++tally->solved;
  tally->ms.push_back(1e3 * seconds);
  if (hidden) ++tally->hidden;
}

struct Group {
  const char* name;
  const char* srdf_name;
  ArmGroup arms;
  Goals goals;
};

struct Outcome {
  int valid{0};
  Tally ours, ours_of_peer, peer;  ///< ours_of_peer: on the problems that the peer had too
  Tally trajectories;              ///< of the whole pipeline
};

/// A problem of one file and all that is needed to plan and to judge.
class Trial {
 public:
  Trial(const ArmProblem& problem, const Group& group, const PlanningOptions& options,
        const ProblemScene& scene, CollisionChecker& checker, CollisionChecker& exact)
      : problem_(problem),
        group_(group),
        options_(options),
        scene_(scene),
        checker_(checker),
        exact_(exact),
        start_(states_of(problem.start, group.arms)),
        goal_(states_of(problem.goal, group.arms)) {}

  [[nodiscard]] bool valid() { return !exact_.contact(start_) && !exact_.contact(goal_); }

  void plan(std::uint64_t seed, bool with_peer, Outcome* outcome) {
    arm::PlannerParams params;
    params.timeout_s = group_.goals.timeout_s;
    params.seed = seed;
    const auto plan = arm::MotionPlanner(checker_, params).plan({start_, {goal_}, {}});
    const bool solved = plan.code == arm::PlanCode::kSuccess;
    if (!solved) complain(seed, plan.message);
    const double seconds = plan.search_s + plan.shortcut_s;
    const bool hidden =
        solved && hides(seed, "path", Judge(exact_).find(plan.waypoints, options_.recheck_rad));
    count(&outcome->ours, solved, seconds, hidden);
    if (with_peer) count(&outcome->ours_of_peer, solved, seconds, hidden);
  }

  void ask_peer(Outcome* outcome) {
    const auto peer = plan_with_ompl(exact_, start_, goal_, options_.peer_timeout_s);
    count(&outcome->peer, peer.solved, peer.seconds,
          peer.solved && Judge(exact_).find(peer.waypoints, options_.recheck_rad));
  }

  /// From the request to the sampled trajectory, as the arm node plans.
  void make_trajectory(std::uint64_t seed, arm::MotionPipeline& pipeline, Outcome* outcome) {
    arm::MotionRequest request;
    request.group = group_.srdf_name;
    request.start = scene_.standing;
    arm::JointPositions goal;
    const auto& names = scene_.model.joint_names();
    for (std::size_t j = 0; j < names.size(); ++j) goal[names[j]] = goal_[static_cast<Eigen::Index>(j)];
    request.goal = goal;
    request.planning_time_s = group_.goals.timeout_s;
    request.seed = seed;
    const auto made = pipeline.plan(request, scene_.world);
    const bool solved = made.code == arm::ArmCode::kSuccess;
    if (!solved) complain(seed, "trajectory: " + made.message);
    count(&outcome->trajectories, solved, made.times.sum_s(), solved && trajectory_hides(seed, made));
  }

 private:
  [[nodiscard]] bool trajectory_hides(std::uint64_t seed, const arm::MotionOutcome& made) {
    const auto path = arm::TimedPath::make(made.joints, made.points);
    const auto ordered = path ? path->only(scene_.model.joint_names()) : path;
    if (!ordered) {
      complain(seed, ordered.error().message);
      return true;
    }
    return hides(seed, "trajectory",
                 Judge(exact_).find([&](double time_s) { return ordered->position(time_s); },
                                    ordered->duration_s(), options_.trajectory_step_s));
  }

  bool hides(std::uint64_t seed, const char* what, const std::optional<HiddenCollision>& found) const {
    if (!found) return false;
    complain(seed, std::string(what) + " hides a collision at " + std::to_string(found->parameter) + ": " +
                       found->contact.first + " and " + found->contact.second + ", " +
                       std::to_string(found->contact.distance_m) + " m");
    return true;
  }

  void complain(std::uint64_t seed, const std::string& what) const {
    std::fprintf(stderr, "  problem %d, seed %llu: %s\n", problem_.index,
                 static_cast<unsigned long long>(seed), what.c_str());
  }

  const ArmProblem& problem_;
  const Group& group_;
  const PlanningOptions& options_;
  const ProblemScene& scene_;
  CollisionChecker &checker_, &exact_;
  const JointVector start_, goal_;
};

Result<void> run_problem(const ArmProblem& problem, const Group& group, const PlanningOptions& options,
                         arm::MotionPipeline& pipeline, Outcome* outcome) {
  const auto scene = make_scene(problem, group.arms);
  if (!scene) return tl::unexpected(scene.error());
  auto checker = CollisionChecker::make(scene->model, scene->world);
  if (!checker) return tl::unexpected(checker.error());
  auto exact = CollisionChecker::make(scene->model, scene->world, {1e-3, false});
  if (!exact) return tl::unexpected(exact.error());
  Trial trial(problem, group, options, *scene, *checker, *exact);
  if (!trial.valid()) return {};
  ++outcome->valid;
  const bool with_peer = outcome->peer.asked < options.peer_count;
  for (int seed = 1; seed <= options.seeds; ++seed) {
    trial.plan(static_cast<std::uint64_t>(seed), with_peer && seed == 1, outcome);
    trial.make_trajectory(static_cast<std::uint64_t>(seed), pipeline, outcome);
  }
  if (with_peer) trial.ask_peer(outcome);
  return {};
}

std::vector<Row> rows_of(const std::string& name, const Goals& goals, Outcome& outcome, int problems) {
  const std::string peer_name = "OMPL RRTConnect on Bullet, 1/64 rad";
  std::vector<Row> rows;
  rows.push_back({name, "valid problems", "", static_cast<double>(outcome.valid),
                  static_cast<double>(problems), "problems"});
  rows.push_back(
      at_least({name, "solved", "%", outcome.ours.solved_percent(), outcome.peer.solved_percent(), peer_name},
               goals.solved_percent));
  rows.push_back(at_most({name, "paths with a hidden collision", "", static_cast<double>(outcome.ours.hidden),
                          static_cast<double>(outcome.peer.hidden), peer_name},
                         0.0));
  rows.push_back({name, "trajectories", "%", outcome.trajectories.solved_percent()});
  rows.push_back(at_most(
      {name, "trajectories with a hidden collision", "", static_cast<double>(outcome.trajectories.hidden)},
      0.0));
  const auto time = [&](const char* metric, double fraction) {
    rows.push_back({name, metric, "ms", percentile(outcome.ours.ms, fraction),
                    percentile(outcome.peer.ms, fraction), peer_name});
  };
  time("plan and simplify, median", 0.5);
  if (goals.median_ms) rows.back() = at_most(rows.back(), *goals.median_ms);
  time("plan and simplify, p75", 0.75);
  time("plan and simplify, p95", 0.95);
  if (goals.p95_ms) rows.back() = at_most(rows.back(), *goals.p95_ms);
  rows.push_back({name, "the peer's problems: median", "ms", percentile(outcome.ours_of_peer.ms, 0.5),
                  percentile(outcome.peer.ms, 0.5), peer_name});
  return rows;
}

/// Files of problems in a folder, by name.
std::vector<std::filesystem::path> problem_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".txt") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// What tells the file from others: "easy" of bookshelf_tall_both_arms_easy_baxter.
std::string short_name(const std::filesystem::path& file) {
  std::string name = file.stem().string();
  if (const auto end = name.rfind("_baxter"); end != std::string::npos) name.erase(end);
  return name.substr(name.rfind('_') + 1);
}

}  // namespace

Result<std::vector<Row>> planning_rows(const PlanningOptions& options) {
  const auto& arms = baxter_arms();
  if (!arms) return tl::unexpected(arms.error());
  std::vector<Row> rows;
  for (const auto& file : problem_files(options.problems)) {
    auto problems = read_problems(file);
    if (!problems) return tl::unexpected(problems.error());
    if (static_cast<int>(problems->size()) > options.count)
      problems->resize(static_cast<std::size_t>(options.count));
    const std::string set = short_name(file);
    // The goals of time were set for the easy problems.
    const bool timed = set == "easy";
    const Goals left{100.0, timed ? std::optional(3.0) : std::nullopt,
                     timed ? std::optional(30.0) : std::nullopt, 3.0};
    const Goals both{99.0, timed ? std::optional(10.0) : std::nullopt, std::nullopt, 3.0};
    for (const Group& group : {Group{"left arm", "left_arm", ArmGroup::kLeft, left},
                               Group{"both arms", "both_arms", ArmGroup::kBoth, both}}) {
      const std::string name = std::string(group.name) + ", " + set;
      std::fprintf(stderr, "planning, %s\n", name.c_str());
      arm::MotionPipeline pipeline(*arms, {});
      Outcome outcome;
      for (const ArmProblem& problem : *problems)
        if (auto done = run_problem(problem, group, options, pipeline, &outcome); !done)
          return tl::unexpected(done.error());
      const auto of_group = rows_of(name, group.goals, outcome, static_cast<int>(problems->size()));
      rows.insert(rows.end(), of_group.begin(), of_group.end());
    }
  }
  return rows;
}

}  // namespace extperfc::benchmark
