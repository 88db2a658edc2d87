#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "extperfc/world/pose.hpp"

#include "mapping/closure_sets.hpp"
#include "mapping/key_frame.hpp"
#include "mapping/pass_matcher.hpp"
#include "mapping/pose_graph.hpp"
#include "mapping/relative_uncertainty.hpp"
#include "mapping/submap_matcher.hpp"

namespace extperfc::mapping {

/// Finds where a path comes back to known surroundings: searches every old submap that the graph's
/// uncertainty allows, verifies what it finds, and accepts loop closures in sets that agree with each other
/// and with the path between them (pairwise consistency: Mangelson et al., ICRA 2018). Searches are
/// remembered, so the scans of the key frames must stay as they are.
class LoopCloser {
 public:
  explicit LoopCloser(SubmapCache& submaps) : matcher_(submaps), passes_(submaps) {}

  static constexpr std::size_t kStride = 8;  ///< key frames from one submap to the next

  /// To score the same key frames with.
  [[nodiscard]] PassMatcher& pass_matcher() { return passes_; }

  /// Forgets the graph's loop closures and finds those of the whole path, from its beginning to its end.
  /// Gives the score of PassMatcher::refine().
  double close_all(const std::vector<KeyFrame>& frames, PoseGraph& graph);
  /// Keeps the graph's loop closures and finds more, for those submaps that have none, in the order of their
  /// distance from those that have some: from there most is known of them. True when it found some.
  bool close_open(const std::vector<KeyFrame>& frames, PoseGraph& graph);
  /// The same, and PassMatcher::refine(), whose score it gives.
  double close_more(const std::vector<KeyFrame>& frames, PoseGraph& graph);
  /// Takes back the loop closures of that stretch of the path whose key frames fit the old submaps about them
  /// worst, and closes it anew from what the rest of the graph knows. `tried`: key frames that are in no such
  /// stretch again; grows. Gives the score of refine(); no value when no stretch that is left fits badly.
  std::optional<double> close_worst_again(const std::vector<KeyFrame>& frames, PoseGraph& graph,
                                          std::vector<bool>& tried);

  /// Key frames [begin, end) that were recognized in earlier passes of the same surroundings.
  struct Pass {
    std::size_t begin{0};
    std::size_t end{0};
  };
  /// Passes between which the graph strains the steps of the path: one of two may be closed wrongly as a
  /// whole, off by one of many doors that look alike. Where the strain is greatest first, the shorter one of
  /// two before the other.
  [[nodiscard]] static std::vector<Pass> doubtful_passes(const PoseGraph& graph);
  /// Takes back the loop closures of a pass, and closes it anew from what the rest of the graph knows. Gives
  /// the score of refine().
  double close_pass_again(const Pass& pass, const std::vector<KeyFrame>& frames, PoseGraph& graph);

 private:
  static void forget_closures(const std::vector<KeyFrame>& frames, PoseGraph& graph);
  /// Searches the submap of `query` in older ones and accepts what is certain. True when a far closure was
  /// accepted.
  bool close(std::size_t query, const std::vector<KeyFrame>& frames, PoseGraph& graph);
  [[nodiscard]] std::vector<std::size_t> references(std::size_t query, const std::vector<KeyFrame>& frames,
                                                    const PoseGraph& graph,
                                                    const std::vector<RelativeUncertainty>& known) const;
  bool match_near(std::size_t reference, std::size_t query, const RelativeUncertainty& known,
                  const std::vector<KeyFrame>& frames, PoseGraph& graph);
  using Pool = std::vector<SubmapClosure>;
  struct Peak {
    std::size_t reference{0};
    Pose2 pose;  ///< of the query in it
    double score{0};
  };
  [[nodiscard]] static Peak from_nearest(const Peak& peak, std::size_t query,
                                         const std::vector<RelativeUncertainty>& known,
                                         const std::vector<KeyFrame>& frames, const PoseGraph& graph);
  [[nodiscard]] std::vector<Peak> find_peaks(const std::vector<std::size_t>& references, std::size_t query,
                                             const std::vector<RelativeUncertainty>& known,
                                             const std::vector<KeyFrame>& frames, const PoseGraph& graph);
  void search_far(const std::vector<std::size_t>& references, std::size_t query,
                  const std::vector<RelativeUncertainty>& known, const std::vector<KeyFrame>& frames,
                  const PoseGraph& graph, Pool& pool);
  bool accept(std::size_t first_new, double min_weight, const std::vector<KeyFrame>& frames, Pool& pool,
              PoseGraph& graph);
  bool join(const std::vector<std::size_t>& references, std::size_t query,
            const std::vector<RelativeUncertainty>& known, const std::vector<KeyFrame>& frames,
            PoseGraph& graph);
  /// Of the graph as it is; made anew after graph_changed().
  [[nodiscard]] const RelativeUncertainties& uncertainties(const PoseGraph& graph);
  void graph_changed() { uncertainties_.reset(); }
  void close_along(bool open_ones_only, const std::vector<KeyFrame>& frames, PoseGraph& graph);

  SubmapMatcher matcher_;
  PassMatcher passes_;
  Pool pool_;     ///< found, not accepted yet
  Pool joining_;  ///< the same, between parts whose poses relative to each other are unknown
  std::map<std::size_t, Pool> anywhere_;                ///< what was found of queries that may stand anywhere
  std::optional<RelativeUncertainties> uncertainties_;  ///< while the graph stays as it is
  std::size_t since_optimized_{0};
};

}  // namespace extperfc::mapping
