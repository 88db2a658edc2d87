#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "extperfc/world/pose.hpp"

#include "mapping/closure_sets.hpp"
#include "mapping/key_frame.hpp"
#include "mapping/pose_graph.hpp"
#include "mapping/submap_cache.hpp"
#include "mapping/wide_search.hpp"

namespace extperfc::mapping {

/// Looks for the submap of one key frame in that of an older one, and verifies what it finds. Both are
/// remembered while the key frames about the two stand as they did. So the scans of the key frames must stay
/// as they are.
class SubmapMatcher {
 public:
  static constexpr double kPeakApartM = 1.0;  ///< poses this far apart, or rotated this far, are two places
  static constexpr double kPeakApartRad = 0.3;

  using Ends = std::pair<std::size_t, std::size_t>;  ///< key frames of the old submap and of the other one

  explicit SubmapMatcher(SubmapCache& submaps) : submaps_(submaps) {}

  /// Up to three poses in the old submap, the best first, by branch and bound.
  [[nodiscard]] std::vector<FoundPose> search(const Ends& ends, const SearchWindow& window,
                                              const std::vector<KeyFrame>& frames, const PoseGraph& graph);
  /// Matches from `start`, and weighs what supports the result. No value where too little fits.
  [[nodiscard]] std::optional<SubmapClosure> verify(const Ends& ends, const Pose2& start,
                                                    const std::vector<KeyFrame>& frames,
                                                    const PoseGraph& graph);

 private:
  struct SubmapPair {
    SubmapShape old;
    SubmapShape seen;
    [[nodiscard]] bool stands_as(const SubmapPair& then) const;
  };
  struct Search {
    SubmapPair submaps;
    SearchWindow window;
    std::vector<FoundPose> found;
  };
  struct Verification {
    SubmapPair submaps;
    Pose2 start;
    std::optional<SubmapClosure> closure;
  };

  [[nodiscard]] static SubmapPair pair_of(const Ends& ends, const PoseGraph& graph);
  [[nodiscard]] std::vector<FoundPose> search_anew(const Ends& ends, const SearchWindow& window,
                                                   const std::vector<KeyFrame>& frames,
                                                   const PoseGraph& graph);
  [[nodiscard]] std::optional<SubmapClosure> verify_anew(const Ends& ends, const Pose2& start,
                                                         const std::vector<KeyFrame>& frames,
                                                         const PoseGraph& graph);

  SubmapCache& submaps_;
  std::map<Ends, Search> searches_;
  std::map<Ends, std::vector<Verification>> verifications_;
};

}  // namespace extperfc::mapping
