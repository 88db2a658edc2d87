#include "mapping/closed_graph.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "mapping/loop_closer.hpp"
#include "mapping/map_parts.hpp"
#include "mapping/path_filter_common.hpp"

namespace extperfc::mapping {

namespace {

/// How well a candidate's key frames fit the old submaps, and it agrees with the tracked steps.
struct Candidate {
  PoseGraph graph;
  double score{0};  ///< see PassMatcher::score()
  double log_likelihood{0};
};

/// How well the key frames of the stretches of a path between unknown steps fit each other where they meet.
class Meetings {
 public:
  Meetings(std::size_t frames, const PoseGraph& steps) : stretch_(frames, 0) {
    for (const Constraint& constraint : steps.constraints())
      if (constraint.is_unknown()) stretch_[constraint.to] = 1;
    std::partial_sum(stretch_.begin(), stretch_.end(), stretch_.begin());
  }

  [[nodiscard]] std::size_t stretches() const { return stretch_.empty() ? 0 : stretch_.back() + 1; }
  void add(const Constraint& match) {
    constexpr double kBadFit = 0.3;
    const Ends ends = ends_of(match);
    for (Meeting* meeting : {&between_[ends], ends.first == ends.second ? &inside_ : nullptr}) {
      if (meeting == nullptr) continue;
      meeting->fit += match.fit;
      meeting->bad += match.fit < kBadFit ? 1 : 0;
      meeting->all += 1;
    }
  }
  /// Whether the stretches that a constraint connects meet in enough places to say anything.
  [[nodiscard]] bool met(const Constraint& constraint) const {
    constexpr double kEnough = 20;
    const auto found = between_.find(ends_of(constraint));
    return found != between_.end() && found->second.all >= kEnough;
  }
  /// False when they fit each other worse than they fit themselves.
  [[nodiscard]] bool fit(const Constraint& constraint) const {
    constexpr double kAtLeast = 0.75;  // of the mean fit
    constexpr double kMoreBad = 0.1;
    const Ends ends = ends_of(constraint);
    if (ends.first == ends.second) return true;
    const auto found = between_.find(ends);
    if (found == between_.end()) return false;
    const Meeting& meeting = found->second;
    return meeting.fit / meeting.all >= kAtLeast * inside_.fit / inside_.all &&
           meeting.bad / meeting.all <= 1.5 * inside_.bad / inside_.all + kMoreBad;
  }

 private:
  struct Meeting {
    double fit{0};
    double bad{0};  ///< those that fit badly
    double all{0};
  };
  using Ends = std::pair<std::size_t, std::size_t>;

  [[nodiscard]] Ends ends_of(const Constraint& constraint) const {
    return {stretch_[constraint.from], stretch_[constraint.to]};
  }

  std::vector<std::size_t> stretch_;  ///< of each key frame
  std::map<Ends, Meeting> between_;
  Meeting inside_{65, 5, 100};  ///< what is usual, before any was seen
};

/// Makes candidates for the graph of one path, and improves them.
class GraphSearch {
 public:
  GraphSearch(const std::vector<KeyFrame>& frames, SubmapCache& submaps)
      : frames_(frames), closer_(submaps) {}

  [[nodiscard]] Candidate from_steps(PoseGraph graph) {
    const double score = closer_.close_all(frames_, graph);
    return with_more_loops(candidate(std::move(graph), score));
  }
  /// Keeps the graph's loop closures.
  [[nodiscard]] Candidate from_graph(PoseGraph graph) {
    const double score = closer_.close_more(frames_, graph);
    return with_more_loops(candidate(std::move(graph), score));
  }
  /// Stretches of the path that fit badly are closed anew, for as long as that makes the whole more likely.
  [[nodiscard]] Candidate reclosed(Candidate best) {
    constexpr int kMaxAttempts = 12;
    constexpr int kMaxFailed = 4;  // one after another
    std::vector<bool> tried;
    for (int attempt = 0, failed = 0; attempt < kMaxAttempts && failed < kMaxFailed; ++attempt, ++failed) {
      PoseGraph again = best.graph;
      const auto score = closer_.close_worst_again(frames_, again, tried);
      if (!score) break;
      Candidate next = candidate(std::move(again), *score);
      if (next.log_likelihood <= best.log_likelihood) continue;
      best = std::move(next);
      failed = -1;
    }
    return best;
  }
  /// The same for whole passes of known surroundings, where two contradict each other.
  [[nodiscard]] Candidate with_passes_reclosed(Candidate best) {
    constexpr int kMaxAttempts = 24;
    std::set<std::pair<std::size_t, std::size_t>> tried;
    const auto is_new = [&](const LoopCloser::Pass& pass) {
      return tried.count({pass.begin, pass.end}) == 0;
    };
    for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
      const auto passes = LoopCloser::doubtful_passes(best.graph);
      const auto pass = std::find_if(passes.begin(), passes.end(), is_new);
      if (pass == passes.end()) break;
      tried.insert({pass->begin, pass->end});
      PoseGraph again = best.graph;
      const double score = closer_.close_pass_again(*pass, frames_, again);
      Candidate next = candidate(std::move(again), score);
      if (next.log_likelihood > best.log_likelihood) best = with_more_loops(std::move(next));
    }
    return best;
  }
  /// Takes back the loop closures across unknown steps, where what they join does not fit all along.
  void check_joints(PoseGraph& graph) {
    const Meetings meetings = meetings_in(graph, graph);
    auto& constraints = graph.constraints();
    const auto is_wrong = [&](const Constraint& constraint) {
      return constraint.is_loop_closure && !meetings.fit(constraint);
    };
    const auto wrong = std::remove_if(constraints.begin(), constraints.end(), is_wrong);
    if (wrong == constraints.end()) return;
    constraints.erase(wrong, constraints.end());
    graph.optimize(0, kGraphIterations);
  }
  /// The unknown steps as odometry measured them. No value when the parts then do not meet, or do not fit.
  [[nodiscard]] std::optional<PoseGraph> as_driven(const PoseGraph& graph,
                                                   const std::vector<Constraint>& driven) {
    const auto parts = parts_of(graph);
    std::vector<Constraint> tried;
    PoseGraph changed = graph;
    for (Constraint& constraint : changed.constraints()) {
      if (!constraint.is_unknown() || parts[constraint.from] == parts[constraint.to]) continue;
      const auto step = std::find_if(driven.begin(), driven.end(),
                                     [&](const Constraint& other) { return other.to == constraint.to; });
      if (step == driven.end()) continue;
      constraint = *step;
      tried.push_back(*step);
    }
    if (tried.empty()) return std::nullopt;
    PoseGraph closed = from_steps(std::move(changed)).graph;
    const Meetings meetings = meetings_in(closed, graph);
    const bool good = std::all_of(tried.begin(), tried.end(), [&](const Constraint& step) {
      return meetings.met(step) && meetings.fit(step);
    });
    if (!good) return std::nullopt;
    return closed;
  }

 private:
  /// How the stretches of the path between the unknown steps of `steps` fit each other at the graph's poses.
  [[nodiscard]] Meetings meetings_in(const PoseGraph& graph, const PoseGraph& steps) {
    Meetings meetings(frames_.size(), steps);
    if (meetings.stretches() > 1)
      for (const Constraint& match : closer_.pass_matcher().match_all(frames_, graph.poses()))
        meetings.add(match);
    return meetings;
  }
  [[nodiscard]] static Candidate candidate(PoseGraph graph, double score) {
    constexpr double kSlipped = 25.0;  // a step's chi-square beyond this counts as this
    double squared_error = 0;
    for (const Constraint& constraint : graph.constraints())
      if (!constraint.is_loop_closure) squared_error += std::min(kSlipped, graph.squared_error(constraint));
    return {std::move(graph), score, kWeightGain * score - 0.5 * squared_error};
  }
  /// Loops that could not be closed before may be, now that others are.
  [[nodiscard]] Candidate with_more_loops(Candidate best) {
    constexpr int kMaxRounds = 2;
    for (int round = 0; round < kMaxRounds; ++round) {
      PoseGraph more = best.graph;
      if (!closer_.close_open(frames_, more)) break;
      const double score = closer_.pass_matcher().refine(frames_, more);
      Candidate next = candidate(std::move(more), score);
      if (next.log_likelihood <= best.log_likelihood) break;
      best = std::move(next);
    }
    return best;
  }

  const std::vector<KeyFrame>& frames_;
  LoopCloser closer_;
};

}  // namespace

PoseGraph closed_graph(const std::vector<KeyFrame>& frames, PoseGraph graph,
                       const std::vector<Constraint>& driven, SubmapCache& submaps) {
  constexpr double kClearly = 0.02;  // of the score ...
  constexpr double kFrames = 2.0;    // ... and key frames
  graph.optimize(0, kGraphIterations);
  GraphSearch search(frames, submaps);
  Candidate by_steps = search.from_steps(graph);
  Candidate by_particles = search.from_graph(std::move(graph));
  const double clearly = kWeightGain * (kClearly * std::abs(by_particles.score) + kFrames);
  const bool particles_win = by_particles.log_likelihood > by_steps.log_likelihood + clearly;
  PoseGraph best =
      search.reclosed(search.with_passes_reclosed(std::move(particles_win ? by_particles : by_steps))).graph;
  search.check_joints(best);
  if (count_parts(best) > 1)
    if (auto joined = search.as_driven(best, driven)) best = *std::move(joined);
  set_parts_apart(best);
  return best;
}

}  // namespace extperfc::mapping
