#include "mapping/closed_graph.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "mapping/loop_closer.hpp"
#include "mapping/map_parts.hpp"
#include "mapping/pass_matcher.hpp"
#include "mapping/path_filter_common.hpp"

namespace extperfc::mapping {

namespace {

/// How well a candidate's key frames fit the old submaps, and it agrees with the tracked steps.
struct Candidate {
  PoseGraph graph;
  double score{0};  ///< see PassMatcher::score()
  double log_likelihood{0};
};

/// How well the key frames of two stretches of the path fit each other where they meet.
struct Meeting {
  double fit{0};
  double bad{0};  ///< those that fit badly
  double all{0};

  void operator+=(const Meeting& other) {
    fit += other.fit;
    bad += other.bad;
    all += other.all;
  }
};

constexpr Meeting kUsualMeeting{65, 5, 100};  // what is known before any was seen

/// Makes candidates for the graph of one path, and improves them.
class GraphSearch {
 public:
  GraphSearch(const std::vector<KeyFrame>& frames, SubmapCache& submaps)
      : frames_(frames), closer_(submaps), passes_(submaps) {}

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
  /// Takes back the loop closures across steps that tell nothing, where what they join does not fit all
  /// along.
  void check_joints(PoseGraph& graph) {
    constexpr double kBadFit = 0.3;
    constexpr double kAtLeast = 0.75;  // of the mean fit inside the stretches
    constexpr double kMoreBad = 0.1;
    std::vector<std::size_t> stretch(frames_.size(), 0);
    for (const Constraint& constraint : graph.constraints())
      if (constraint.is_unknown()) stretch[constraint.to] = 1;
    std::partial_sum(stretch.begin(), stretch.end(), stretch.begin());
    if (stretch.back() == 0) return;
    std::map<std::pair<std::size_t, std::size_t>, Meeting> meetings;
    for (const Constraint& match : passes_.match_all(frames_, graph.poses())) {
      Meeting& meeting = meetings[{stretch[match.from], stretch[match.to]}];
      meeting.fit += match.fit;
      meeting.bad += match.fit < kBadFit ? 1 : 0;
      meeting.all += 1;
    }
    Meeting inside = kUsualMeeting;
    for (const auto& [ends, meeting] : meetings)
      if (ends.first == ends.second) inside += meeting;
    auto& constraints = graph.constraints();
    const auto is_wrong = [&](const Constraint& constraint) {
      const std::pair<std::size_t, std::size_t> ends{stretch[constraint.from], stretch[constraint.to]};
      if (!constraint.is_loop_closure || ends.first == ends.second) return false;
      const Meeting& meeting = meetings[ends];
      return meeting.fit / meeting.all < kAtLeast * inside.fit / inside.all ||
             meeting.bad / meeting.all > 1.5 * inside.bad / inside.all + kMoreBad;
    };
    const auto wrong = std::remove_if(constraints.begin(), constraints.end(), is_wrong);
    if (wrong == constraints.end()) return;
    constraints.erase(wrong, constraints.end());
    graph.optimize(0, kGraphIterations);
  }

 private:
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
      const double score = passes_.refine(frames_, more);
      Candidate next = candidate(std::move(more), score);
      if (next.log_likelihood <= best.log_likelihood) break;
      best = std::move(next);
    }
    return best;
  }

  const std::vector<KeyFrame>& frames_;
  LoopCloser closer_;
  PassMatcher passes_;
};

}  // namespace

PoseGraph closed_graph(const std::vector<KeyFrame>& frames, PoseGraph graph, SubmapCache& submaps) {
  constexpr double kClearly = 0.02;  // of the score ...
  constexpr double kFrames = 2.0;    // ... and key frames
  graph.optimize(0, kGraphIterations);
  GraphSearch search(frames, submaps);
  Candidate by_steps = search.from_steps(graph);
  Candidate by_particles = search.from_graph(std::move(graph));
  const double clearly = kWeightGain * (kClearly * std::abs(by_particles.score) + kFrames);
  const bool particles_win = by_particles.log_likelihood > by_steps.log_likelihood + clearly;
  PoseGraph best = search.reclosed(std::move(particles_win ? by_particles : by_steps)).graph;
  search.check_joints(best);
  set_parts_apart(best);
  return best;
}

}  // namespace extperfc::mapping
