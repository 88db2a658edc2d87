#include "arm/planning/shortcuts.hpp"

#include <algorithm>
#include <cstddef>

#include "extperfc/arm/motion_planner.hpp"

namespace extperfc::arm {

namespace {

using Path = std::vector<JointVector>;

/// A place on a path: behind waypoint `segment`, `fraction` of the distance to the next.
struct Place {
  std::size_t segment{0};
  JointVector state;
};

Place place_at(const Path& path, double along_rad) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const double length = (path[i + 1] - path[i]).norm();
    if (along_rad < length || i + 2 == path.size()) {
      const double fraction = length > 0 ? std::clamp(along_rad / length, 0.0, 1.0) : 0.0;
      return {i, path[i] + fraction * (path[i + 1] - path[i])};
    }
    along_rad -= length;
  }
  return {0, path.front()};
}

// From each waypoint kept, to the farthest that a free straight segment reaches; halving keeps the number of
// asked segments below 2 log2(n) for each.
Path leave_out(CollisionChecker& checker, const Path& path, const std::function<bool()>& stop) {
  Path kept{path.front()};
  std::size_t at = 0;
  while (at + 1 < path.size()) {
    std::size_t next = at + 1;
    for (std::size_t jump = path.size() - 1 - at; jump > 1 && !stop(); jump /= 2) {
      if (at + jump <= next || !checker.motion_free(path[at], path[at + jump])) continue;
      next = at + jump;
      break;
    }
    kept.push_back(path[next]);
    at = next;
  }
  return kept;
}

// Replaces what lies between two places by the straight segment, when that is free and shorter.
void cut(CollisionChecker& checker, Path* path, const Place& from, const Place& to) {
  if (from.segment == to.segment) return;
  double old_length =
      (path->at(from.segment + 1) - from.state).norm() + (to.state - path->at(to.segment)).norm();
  for (std::size_t i = from.segment + 1; i < to.segment; ++i)
    old_length += (path->at(i + 1) - path->at(i)).norm();
  if ((to.state - from.state).norm() > old_length - kMinGainRad) return;
  if (checker.motion_free(from.state, to.state))
    replace(path, from.segment, to.segment, {from.state, to.state});
}

}  // namespace

void cut_at_random(Path* path, int rounds, Rng& rng, const std::function<bool()>& stop, const Cut& cut) {
  for (int round = 0; round < rounds && path->size() > 2 && !stop(); ++round) {
    const double length = path_length(*path);
    const double a = rng.uniform(0, length);
    const double b = rng.uniform(0, length);
    cut(path, std::min(a, b), std::max(a, b));
  }
}

void replace(Path* path, std::size_t from, std::size_t to, const Path& between) {
  const auto behind = path->begin() + static_cast<std::ptrdiff_t>(from) + 1;
  const auto at = path->erase(behind, path->begin() + static_cast<std::ptrdiff_t>(to) + 1);
  path->insert(at, between.begin(), between.end());
}

Path shorten(CollisionChecker& checker, Path waypoints, int rounds, Rng& rng,
             const std::function<bool()>& stop) {
  if (waypoints.size() < 3 || rounds <= 0) return waypoints;
  waypoints = leave_out(checker, waypoints, stop);
  cut_at_random(&waypoints, rounds, rng, stop, [&](Path* path, double from_rad, double to_rad) {
    cut(checker, path, place_at(*path, from_rad), place_at(*path, to_rad));
  });
  return leave_out(checker, waypoints, stop);
}

}  // namespace extperfc::arm
