#pragma once

#include <cstddef>
#include <vector>

#include "extperfc/world/pose.hpp"

#include "mapping/key_frame.hpp"
#include "mapping/pose_graph.hpp"
#include "mapping/submap_cache.hpp"

namespace extperfc::mapping {

/// Matches key frames in the submaps of earlier passes of the same surroundings.
class PassMatcher {
 public:
  explicit PassMatcher(SubmapCache& submaps) : submaps_(submaps) {}

  /// Every key frame in up to two old submaps about it, good and bad fits alike.
  [[nodiscard]] std::vector<Constraint> match_all(const std::vector<KeyFrame>& frames,
                                                  const std::vector<Pose2>& poses);
  /// Sums over the key frames how much better (or worse) than by chance they fit the old submaps about them:
  /// of two graphs of one path, that with the higher score agrees better with itself.
  [[nodiscard]] double score(const std::vector<KeyFrame>& frames, const PoseGraph& graph);
  /// Adds the matches that fit as loop closures, and optimizes the graph. Gives the score before the last
  /// round.
  double refine(const std::vector<KeyFrame>& frames, PoseGraph& graph);

 private:
  [[nodiscard]] std::vector<std::size_t> passes(std::size_t query, const std::vector<KeyFrame>& frames,
                                                const std::vector<Pose2>& poses) const;
  [[nodiscard]] Constraint match_scan(std::size_t reference, std::size_t query,
                                      const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses);

  SubmapCache& submaps_;
};

}  // namespace extperfc::mapping
