#include "arm/constrained/manifold.hpp"

#include <algorithm>
#include <utility>

namespace extperfc::arm {

namespace {

/// A step must come this fraction of itself nearer to the target.
constexpr double kMinProgress = 0.1;
/// A projected step longer than this many steps has jumped to another place.
constexpr double kMaxStep = 1.5;
/// The middle of a piece, projected, lies within this fraction of the piece's length of both ends.
constexpr double kMaxHalf = 0.75;
/// Error of a projected state [m] or [rad].
constexpr double kExact = 2e-8;
constexpr int kMaxHalvings = 14;

}  // namespace

Manifold::Manifold(CollisionChecker& checker, PathConstraint constraint, JointLimits limits,
                   const Steps& steps)
    : checker_(checker), constraint_(std::move(constraint)), limits_(std::move(limits)), steps_(steps) {}

std::optional<JointVector> Manifold::sample(Rng& rng) const {
  JointVector state(limits_.lower.size());
  for (Eigen::Index j = 0; j < state.size(); ++j) state[j] = rng.uniform(limits_.lower[j], limits_.upper[j]);
  return constraint_.project(state, limits_);
}

Manifold::Walk Manifold::walk(const JointVector& from, const JointVector& to, double max_rad,
                              const std::function<bool()>& stop) const {
  Walk walk;
  JointVector at = from;
  double left = (to - at).norm();
  for (double walked = 0; walked < max_rad && !stop();) {
    if (left <= steps_.step_rad) {
      walk.states.push_back(to);
      walk.reached = true;
      return walk;
    }
    const JointVector along = constraint_.tangent(at, to - at, limits_);
    const double length = along.norm();
    if (length < kMinProgress * left) return walk;
    const auto next = constraint_.project(at + along * (steps_.step_rad / length), limits_);
    if (!next) return walk;
    const double step = (*next - at).norm();
    const double now_left = (to - *next).norm();
    if (step > kMaxStep * steps_.step_rad || now_left > left - kMinProgress * steps_.step_rad) return walk;
    at = *next;
    left = now_left;
    walked += step;
    walk.states.push_back(at);
  }
  return walk;
}

bool Manifold::fine(const JointVector& from, const JointVector& to, bool exact) const {
  return (exact ? constraint_.segment_error(from, to, kExact) : constraint_.segment_error(from, to)) <=
         steps_.tolerance;
}

// "Exact" are states that were projected; a start or a goal may be off by the tolerance.
bool Manifold::halve(const JointVector& from, const JointVector& to, bool from_exact, bool to_exact,
                     int depth, States* pieces) const {
  if (fine(from, to, from_exact && to_exact)) {
    pieces->push_back(to);
    return true;
  }
  if (depth == 0) return false;
  const auto middle = constraint_.project(0.5 * (from + to), limits_);
  if (!middle) return false;
  const double max_distance = kMaxHalf * (to - from).norm();
  if ((*middle - from).norm() > max_distance || (*middle - to).norm() > max_distance) return false;
  return halve(from, *middle, from_exact, true, depth - 1, pieces) &&
         halve(*middle, to, true, to_exact, depth - 1, pieces);
}

bool Manifold::refine(const JointVector& from, const JointVector& to, States* pieces) const {
  return halve(from, to, constraint_.error(from) <= kExact, constraint_.error(to) <= kExact, kMaxHalvings,
               pieces);
}

std::size_t Manifold::prove(const JointVector& from, const States& coarse, States* pieces,
                            const std::function<bool()>& stop) {
  const std::vector<bool> free = checker_.are_free(coarse);
  JointVector at = from;
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    if (!free[i] || stop()) return i;
    States between;
    if (!refine(at, coarse[i], &between)) return i;
    for (const auto& next : between) {
      if (!checker_.motion_free(at, next)) return i;
      at = next;
    }
    pieces->insert(pieces->end(), between.begin(), between.end());
  }
  return coarse.size();
}

std::optional<States> Manifold::connect(const JointVector& from, const JointVector& to, double max_rad,
                                        const std::function<bool()>& stop) {
  const Walk coarse = walk(from, to, max_rad, stop);
  if (!coarse.reached) return std::nullopt;
  States pieces;
  if (prove(from, coarse.states, &pieces, stop) < coarse.states.size()) return std::nullopt;
  return pieces;
}

double Manifold::error_bound(const States& path) const {
  double worst = path.empty() ? 0.0 : constraint_.error(path.front());
  for (std::size_t i = 1; i < path.size(); ++i)
    worst = std::max(worst, constraint_.segment_error(path[i - 1], path[i]));
  return worst;
}

bool Manifold::holds(const JointVector& from, const JointVector& to) {
  return constraint_.segment_error(from, to) <= steps_.tolerance && checker_.motion_free(from, to);
}

}  // namespace extperfc::arm
