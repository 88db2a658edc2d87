#pragma once

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "extperfc/world/pose.hpp"

#include "mapping/key_frame.hpp"
#include "mapping/pose_graph.hpp"
#include "mapping/submap_cache.hpp"

namespace extperfc::mapping {

/// Matches key frames in the submaps of earlier passes of the same surroundings. Matches are remembered: one
/// is made again where the key frame, or the submap's key frames, moved since. So the scans of the key frames
/// must stay as they are.
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
  /// A match, and where it was made.
  struct Match {
    Constraint constraint;
    Pose2 start;  ///< of the key frame in the submap
    SubmapShape submap;
  };

  [[nodiscard]] std::vector<std::size_t> passes(std::size_t query, const std::vector<KeyFrame>& frames,
                                                const std::vector<Pose2>& poses) const;
  [[nodiscard]] Constraint match_scan(std::size_t reference, std::size_t query,
                                      const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses);
  [[nodiscard]] Constraint remembered_match(std::size_t reference, std::size_t query,
                                            const std::vector<KeyFrame>& frames,
                                            const std::vector<Pose2>& poses);

  SubmapCache& submaps_;
  std::map<std::pair<std::size_t, std::size_t>, Match> matches_;  ///< of reference and query
};

}  // namespace extperfc::mapping
