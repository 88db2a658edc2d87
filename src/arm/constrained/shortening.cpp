#include "arm/constrained/shortening.hpp"

#include <algorithm>
#include <cstddef>

#include "arm/planning/shortcuts.hpp"

namespace extperfc::arm {

namespace {

std::vector<double> lengths_along(const States& path) {
  std::vector<double> along{0.0};
  for (std::size_t i = 1; i < path.size(); ++i)
    along.push_back(along.back() + (path[i] - path[i - 1]).norm());
  return along;
}

std::size_t index_at(const std::vector<double>& along, double length) {
  const auto found = std::lower_bound(along.begin(), along.end(), length);
  return std::min(static_cast<std::size_t>(found - along.begin()), along.size() - 1);
}

double length_of(const JointVector& from, const States& pieces) {
  double length = pieces.empty() ? 0.0 : (pieces.front() - from).norm();
  for (std::size_t i = 1; i < pieces.size(); ++i) length += (pieces[i] - pieces[i - 1]).norm();
  return length;
}

// The coarse walk gives its length before anything is proven.
void cut(Manifold& manifold, States* path, std::size_t from, std::size_t to, double old_length,
         const std::function<bool()>& stop) {
  const JointVector first = (*path)[from];
  if ((path->at(to) - first).norm() > old_length - kMinGainRad) return;
  const auto walk = manifold.walk(first, path->at(to), old_length, stop);
  if (!walk.reached || length_of(first, walk.states) > old_length - kMinGainRad) return;
  States pieces;
  if (manifold.prove(first, walk.states, &pieces, stop) < walk.states.size()) return;
  if (length_of(first, pieces) > old_length - kMinGainRad) return;
  replace(path, from, to, pieces);
}

States leave_out(Manifold& manifold, const States& path, const std::function<bool()>& stop) {
  States kept{path.front()};
  for (std::size_t at = 0; at + 1 < path.size();) {
    std::size_t next = at + 1;
    while (next + 1 < path.size() && !stop() && manifold.holds(path[at], path[next + 1])) ++next;
    kept.push_back(path[next]);
    at = next;
  }
  return kept;
}

}  // namespace

States shorten(Manifold& manifold, States waypoints, int rounds, Rng& rng,
               const std::function<bool()>& stop) {
  if (waypoints.size() < 3 || rounds <= 0) return waypoints;
  cut_at_random(&waypoints, rounds, rng, stop, [&](States* path, double from_rad, double to_rad) {
    const auto along = lengths_along(*path);
    const std::size_t from = index_at(along, from_rad), to = index_at(along, to_rad);
    if (to > from + 1) cut(manifold, path, from, to, along[to] - along[from], stop);
  });
  return leave_out(manifold, waypoints, stop);
}

}  // namespace extperfc::arm
