#include "mapping/submap_cache.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::mapping {

namespace {

constexpr double kMovedM = 0.01;
constexpr double kMovedRad = 0.002;

bool moved(const Pose2& a, const Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y) > kMovedM || std::abs(wrap_angle(a.yaw - b.yaw)) > kMovedRad;
}

void draw(Submap& submap, const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses) {
  const Pose2& middle = poses[submap.key_frame];
  submap.map.clear();
  submap.pyramid.reset();
  for (std::size_t i = submap.first; i < submap.last; ++i)
    submap.map.add(frames[i].points, between(middle, poses[i]));
  submap.profiles.clear();
  submap.profile_poses.clear();
  for (const std::size_t i : {submap.first, submap.key_frame, submap.last - 1}) {
    submap.profiles.emplace_back(frames[i].points);
    submap.profile_poses.push_back(between(middle, poses[i]));
  }
  submap.first_seen = between(middle, poses[submap.first]);
  submap.last_seen = between(middle, poses[submap.last - 1]);
}

}  // namespace

double contradictions(const Submap& submap, const ScanPoints& points, const RangeProfile& profile,
                      const Pose2& submap_T_base) {
  constexpr double kRadiusM = 8.0;
  double in_free_space = 0;
  for (std::size_t i = 0; i < submap.profiles.size(); ++i)
    in_free_space = std::max(
        in_free_space,
        fraction_in_free_space(submap.profiles[i], points, between(submap.profile_poses[i], submap_T_base)));
  return 0.5 * (in_free_space + fraction_seen_through(profile, submap.map, submap_T_base, kRadiusM));
}

Submap& SubmapCache::at(std::size_t key_frame, std::size_t end, const std::vector<KeyFrame>& frames,
                        const std::vector<Pose2>& poses) {
  const std::size_t first = key_frame - std::min(key_frame, kHalfWidth);
  const std::size_t last = std::min(key_frame + kHalfWidth, end);
  ++clock_;
  for (const auto& submap : submaps_) {
    if (submap->key_frame != key_frame || submap->first != first || submap->last != last) continue;
    submap->used = clock_;
    const Pose2& middle = poses[key_frame];
    if (moved(submap->first_seen, between(middle, poses[first])) ||
        moved(submap->last_seen, between(middle, poses[last - 1])))
      draw(*submap, frames, poses);
    return *submap;
  }
  if (submaps_.size() >= kMaxSubmaps)
    submaps_.erase(std::min_element(submaps_.begin(), submaps_.end(),
                                    [](const auto& a, const auto& b) { return a->used < b->used; }));
  auto submap = std::make_unique<Submap>();
  submap->key_frame = key_frame;
  submap->first = first;
  submap->last = last;
  submap->used = clock_;
  draw(*submap, frames, poses);
  submaps_.push_back(std::move(submap));
  return *submaps_.back();
}

}  // namespace extperfc::mapping
