#include "mapping/thinning.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "mapping/loop_closer.hpp"
#include "mapping/path_filter_common.hpp"

namespace extperfc::mapping {

namespace {

constexpr std::size_t kGroup = LoopCloser::kStride;
constexpr std::size_t kNewest = 200;   // key frames that stay
constexpr std::size_t kMaxGroups = 4;  // of a call

/// Where key frames stand and look.
using Place = std::tuple<long, long, long>;

Place place_of(const Pose2& pose) {
  constexpr double kSameM = 1.0;
  constexpr double kSameRad = 0.5;
  return {std::lround(pose.x / kSameM), std::lround(pose.y / kSameM), std::lround(pose.yaw / kSameRad)};
}

/// The number of passes that the ascending key frames [first, last) belong to.
template <typename Iterator>
std::size_t passes(Iterator first, Iterator last) {
  std::size_t count = first == last ? 0 : 1;
  for (Iterator next = first; next != last && ++next != last; first = next)
    count += *next - *first > kOtherPassFrames ? 1 : 0;
  return count;
}

/// The key frames of every place, those that are left out taken away.
class Places {
 public:
  Places(const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses) : poses_(poses) {
    for (std::size_t i = 0; i < frames.size(); ++i)
      if (!frames[i].is_thinned()) frames_[place_of(poses[i])].push_back(i);
  }

  [[nodiscard]] bool has_passes_beside(std::size_t frame, std::size_t wanted) const {
    const auto& here = frames_.at(place_of(poses_[frame]));
    const std::size_t before = frame - std::min(frame, kOtherPassFrames);
    return passes(here.begin(), std::lower_bound(here.begin(), here.end(), before)) >= wanted &&
           passes(std::upper_bound(here.begin(), here.end(), frame + kOtherPassFrames), here.end()) >= wanted;
  }
  void remove(std::size_t frame) {
    auto& here = frames_.at(place_of(poses_[frame]));
    here.erase(std::lower_bound(here.begin(), here.end(), frame));
  }

 private:
  const std::vector<Pose2>& poses_;
  std::map<Place, std::vector<std::size_t>> frames_;
};

}  // namespace

std::vector<std::size_t> seen_often(const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses,
                                    std::size_t kept_passes) {
  std::vector<std::size_t> found;
  if (kept_passes == 0) return found;
  Places places(frames, poses);
  std::vector<std::size_t> group(kGroup);
  for (std::size_t first = 0; first + kGroup + kNewest <= frames.size(); first += kGroup) {
    if (frames[first].is_thinned()) continue;
    std::iota(group.begin(), group.end(), first);
    if (!std::all_of(group.begin(), group.end(),
                     [&](std::size_t i) { return places.has_passes_beside(i, kept_passes); }))
      continue;
    for (const std::size_t i : group) places.remove(i);
    found.insert(found.end(), group.begin(), group.end());
    if (found.size() == kMaxGroups * kGroup) break;
  }
  return found;
}

}  // namespace extperfc::mapping
