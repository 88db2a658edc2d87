#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "extperfc/world/pose.hpp"

#include "mapping/key_frame.hpp"
#include "mapping/surface_map.hpp"
#include "mapping/visibility.hpp"
#include "mapping/wide_search.hpp"

namespace extperfc::mapping {

/// Key frames about an old one, and where the outermost stand in its frame: shows when what was made of them
/// is out of date.
struct SubmapShape {
  std::size_t key_frame{0};
  std::size_t first{0};  ///< key frames [first, last) make it up
  std::size_t last{0};
  Pose2 first_seen;  ///< of `first`
  Pose2 last_seen;   ///< of `last - 1`
};

/// Whether a submap's key frames stand as they did, to 1 cm and 2 mrad: what was made of them still holds.
[[nodiscard]] bool is_unchanged(const SubmapShape& now, const SubmapShape& then);

/// Surfaces around an old key frame, in that key frame's frame, as they were when the map was drawn.
struct Submap : SubmapShape {
  SurfaceMap map;
  ScanPoints points;                       ///< its surfaces, thinned, as if one scan had seen them
  std::vector<RangeProfile> profiles;      ///< of `first`, `key_frame` and `last - 1` ...
  std::vector<Pose2> profile_poses;        ///< ... and where those stand here
  std::unique_ptr<SearchPyramid> pyramid;  ///< made when a wide search first needs it
  std::uint64_t used{0};
};

/// Fraction of contradictions between a scan at `submap_T_base` and a submap: points where the submap is
/// free, surfaces that the scan saw through. [0, 1]
[[nodiscard]] double contradictions(const Submap& submap, const ScanPoints& points,
                                    const RangeProfile& profile, const Pose2& submap_T_base);
/// The same between two submaps.
[[nodiscard]] double contradictions(const Submap& submap, const Submap& other, const Pose2& submap_T_other);

/// Submaps of old key frames, shared by all particles: drawn on demand, redrawn when an optimization moved
/// their key frames, dropped when others were used more recently. Memory is bounded by kMaxSubmaps.
class SubmapCache {
 public:
  static constexpr std::size_t kMaxSubmaps = 64;
  static constexpr std::size_t kHalfWidth = 8;  ///< key frames before and after the middle

  /// Of the submap around `key_frame`, from key frames before `end` only, at these poses.
  [[nodiscard]] static SubmapShape shape_of(std::size_t key_frame, std::size_t end,
                                            const std::vector<Pose2>& poses);
  /// The submap around `key_frame`, from key frames before `end` only. Valid until the next call.
  [[nodiscard]] Submap& at(std::size_t key_frame, std::size_t end, const std::vector<KeyFrame>& frames,
                           const std::vector<Pose2>& poses);
  /// Key frames were thinned: submaps are drawn anew.
  void clear() { submaps_.clear(); }

 private:
  std::vector<std::unique_ptr<Submap>> submaps_;
  std::uint64_t clock_{0};
};

}  // namespace extperfc::mapping
