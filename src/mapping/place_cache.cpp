#include "mapping/place_cache.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::mapping {

namespace {

constexpr double kBentM = 0.01;
constexpr double kBentRad = 0.002;

bool moved(const Pose2& a, const Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y) > kBentM || std::abs(wrap_angle(a.yaw - b.yaw)) > kBentRad;
}

void draw(Place& place, const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses) {
  const Pose2& middle = poses[place.key_frame];
  place.map.clear();
  place.pyramid.reset();
  for (std::size_t i = place.first; i < place.last; ++i)
    place.map.add(frames[i].points, between(middle, poses[i]));
  place.profiles.clear();
  place.profile_poses.clear();
  for (const std::size_t i : {place.first, place.key_frame, place.last - 1}) {
    place.profiles.emplace_back(frames[i].points);
    place.profile_poses.push_back(between(middle, poses[i]));
  }
  place.first_seen = between(middle, poses[place.first]);
  place.last_seen = between(middle, poses[place.last - 1]);
}

}  // namespace

double contradictions(const Place& place, const ScanPoints& points, const RangeProfile& profile,
                      const Pose2& place_T_base) {
  constexpr double kRadiusM = 8.0;
  double in_free_space = 0;
  for (std::size_t i = 0; i < place.profiles.size(); ++i)
    in_free_space = std::max(
        in_free_space,
        share_in_free_space(place.profiles[i], points, between(place.profile_poses[i], place_T_base)));
  return 0.5 * (in_free_space + share_seen_through(profile, place.map, place_T_base, kRadiusM));
}

Place& PlaceCache::at(std::size_t key_frame, std::size_t end, const std::vector<KeyFrame>& frames,
                      const std::vector<Pose2>& poses) {
  const std::size_t first = key_frame - std::min(key_frame, kHalfWidth);
  const std::size_t last = std::min(key_frame + kHalfWidth, end);
  ++clock_;
  for (const auto& place : places_) {
    if (place->key_frame != key_frame || place->first != first || place->last != last) continue;
    place->used = clock_;
    const Pose2& middle = poses[key_frame];
    if (moved(place->first_seen, between(middle, poses[first])) ||
        moved(place->last_seen, between(middle, poses[last - 1])))
      draw(*place, frames, poses);
    return *place;
  }
  if (places_.size() >= kMost)
    places_.erase(std::min_element(places_.begin(), places_.end(),
                                   [](const auto& a, const auto& b) { return a->used < b->used; }));
  auto place = std::make_unique<Place>();
  place->key_frame = key_frame;
  place->first = first;
  place->last = last;
  place->used = clock_;
  draw(*place, frames, poses);
  places_.push_back(std::move(place));
  return *places_.back();
}

}  // namespace extperfc::mapping
