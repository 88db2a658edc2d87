#include "mapping/closed_graph.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mapping/loop_closer.hpp"
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
  return search.reclosed(std::move(particles_win ? by_particles : by_steps)).graph;
}

}  // namespace extperfc::mapping
