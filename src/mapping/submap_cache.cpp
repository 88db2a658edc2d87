#include "mapping/submap_cache.hpp"

#include <algorithm>

#include "mapping/pose_distance.hpp"

namespace extperfc::mapping {

namespace {

/// Every n-th surface, so that there are kMaxSubmapPoints at most.
ScanPoints thinned(const SurfaceMap& map) {
  constexpr std::size_t kMaxSubmapPoints = 500;
  ScanPoints points;
  map.visit([&](const SurfaceMap::Surface& surface) {
    if (surface.weight >= 2) points.surface.push_back({surface.mean, surface.normal});
  });
  const std::size_t step = 1 + points.surface.size() / kMaxSubmapPoints;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.surface.size(); i += step) points.surface[kept++] = points.surface[i];
  points.surface.resize(kept);
  return points;
}

void draw(const SubmapShape& shape, const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses,
          Submap& submap) {
  static_cast<SubmapShape&>(submap) = shape;
  const Pose2& middle = poses[submap.key_frame];
  submap.map.clear();
  submap.pyramid.reset();
  for (std::size_t i = submap.first; i < submap.last; ++i)
    submap.map.add(frames[i].points, between(middle, poses[i]));
  submap.points = thinned(submap.map);
  submap.profiles.clear();
  submap.profile_poses.clear();
  for (const std::size_t i : {submap.first, submap.key_frame, submap.last - 1}) {
    if (frames[i].is_thinned()) continue;
    submap.profiles.emplace_back(frames[i].points);
    submap.profile_poses.push_back(between(middle, poses[i]));
  }
}

}  // namespace

bool is_unchanged(const SubmapShape& now, const SubmapShape& then) {
  return now.key_frame == then.key_frame && now.first == then.first && now.last == then.last &&
         stands_still(now.first_seen, then.first_seen) && stands_still(now.last_seen, then.last_seen);
}

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

double contradictions(const Submap& submap, const Submap& other, const Pose2& submap_T_other) {
  const auto worst_in = [](const Submap& seen, const ScanPoints& points, const Pose2& seen_T_points) {
    double worst = 0;
    for (std::size_t i = 0; i < seen.profiles.size(); ++i)
      worst = std::max(worst, fraction_in_free_space(seen.profiles[i], points,
                                                     between(seen.profile_poses[i], seen_T_points)));
    return worst;
  };
  return 0.5 * (worst_in(submap, other.points, submap_T_other) +
                worst_in(other, submap.points, inverse(submap_T_other)));
}

SubmapShape SubmapCache::shape_of(std::size_t key_frame, std::size_t end, const std::vector<Pose2>& poses) {
  const std::size_t first = key_frame - std::min(key_frame, kHalfWidth);
  const std::size_t last = std::min(key_frame + kHalfWidth, end);
  const Pose2& middle = poses[key_frame];
  return {key_frame, first, last, between(middle, poses[first]), between(middle, poses[last - 1])};
}

Submap& SubmapCache::at(std::size_t key_frame, std::size_t end, const std::vector<KeyFrame>& frames,
                        const std::vector<Pose2>& poses) {
  const SubmapShape shape = shape_of(key_frame, end, poses);
  ++clock_;
  for (const auto& submap : submaps_) {
    if (submap->key_frame != key_frame || submap->first != shape.first || submap->last != shape.last)
      continue;
    submap->used = clock_;
    if (!is_unchanged(shape, *submap)) draw(shape, frames, poses, *submap);
    return *submap;
  }
  if (submaps_.size() >= kMaxSubmaps)
    submaps_.erase(std::min_element(submaps_.begin(), submaps_.end(),
                                    [](const auto& a, const auto& b) { return a->used < b->used; }));
  auto submap = std::make_unique<Submap>();
  submap->used = clock_;
  draw(shape, frames, poses, *submap);
  submaps_.push_back(std::move(submap));
  return *submaps_.back();
}

}  // namespace extperfc::mapping
