#include "navigate/global/footprint_refiner.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "extperfc/base/math.hpp"

#include "navigate/global/path_shape.hpp"
#include "navigate/global/pose_search.hpp"

namespace extperfc::navigate {

namespace {

/// How far a search for a passage reaches: along the path beyond the contact, and to both sides.
struct Reach {
  double margin_m;
  double half_width_m;
  double steps_per_cell;
  int yaws;
  bool from_first_yaw;  ///< the lattice has the first pose's yaw, not that along the walls
};
constexpr std::array<Reach, 4> kReaches{
    {{0.5, 0.3, 1, 48, false}, {1.0, 0.4, 2, 64, false}, {1.0, 0.4, 2, 64, true}, {2.0, 1.0, 1, 64, false}}};
constexpr double kApart_m = 0.6;  // contacts nearer to each other are one
constexpr double kMaxStep_m = 0.05;

double apart_m(const Pose2& a, const Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

}  // namespace

bool FootprintRefiner::is_free(const Pose2& pose) const {
  const Contact touched = contact(costs_, footprint_, pose);
  return touched == Contact::kFree || (touched == Contact::kUnknown && traversal_.admits(kUnknownCost));
}

bool FootprintRefiner::is_free_along(const Pose2& from, const Pose2& to) const {
  if (!traversal_.admits(kUnknownCost)) return contact_along(costs_, footprint_, from, to) == Contact::kFree;
  const double yaw = wrap_angle(to.yaw - from.yaw);
  const double motion_m = apart_m(from, to) + std::abs(yaw) * footprint_.circumscribed_radius_m();
  const double steps = std::max(1.0, std::ceil(motion_m / (0.5 * costs_.resolution_m)));
  for (double k = 0; k <= steps; ++k) {
    const double part = k / steps;
    if (!is_free({from.x + part * (to.x - from.x), from.y + part * (to.y - from.y), from.yaw + part * yaw}))
      return false;
  }
  return true;
}

bool FootprintRefiner::passes(const Pose2& from, const Pose2& to) const {
  const std::vector<Pose2> poses = densify({from, to});
  for (std::size_t i = 1; i < poses.size(); ++i)
    if (!is_free_along(poses[i - 1], poses[i])) return false;
  return true;
}

/// The last poses, before `end`, on or between which the footprint touches.
std::optional<FootprintRefiner::Span> FootprintRefiner::last_contact(const std::vector<Pose2>& poses,
                                                                     std::size_t end) const {
  std::optional<Span> span;
  for (std::size_t i = end; i-- > 1;) {
    if (span && apart_m(poses[i], poses[span->first]) > kApart_m) break;
    if (is_free_along(poses[i - 1], poses[i])) continue;
    span = Span{i - 1, span ? span->last : i};
  }
  return span;
}

FootprintRefiner::Span FootprintRefiner::widened(const std::vector<Pose2>& poses, const Span& span,
                                                 double margin_m) const {
  Span wide = span;
  for (double passed_m = 0; wide.first > 0; --wide.first) {
    if (passed_m >= margin_m && is_free(poses[wide.first])) break;
    passed_m += std::max(1e-3, apart_m(poses[wide.first], poses[wide.first - 1]));
  }
  for (double passed_m = 0; wide.last + 1 < poses.size(); ++wide.last) {
    if (passed_m >= margin_m && is_free(poses[wide.last])) break;
    passed_m += std::max(1e-3, apart_m(poses[wide.last], poses[wide.last + 1]));
  }
  return wide;
}

/// The yaw in the middle of those that are free where the footprint touches, nearest to the path's own: along
/// the walls of a narrow passage.
double FootprintRefiner::aligned_yaw(const std::vector<Pose2>& poses, const Span& span) const {
  constexpr int kYaws = 180;
  const Pose2 middle = poses[(span.first + span.last) / 2];
  std::array<bool, kYaws> free{};
  for (int k = 0; k < kYaws; ++k)
    free[static_cast<std::size_t>(k)] = is_free({middle.x, middle.y, middle.yaw + kTwoPi * k / kYaws});
  double best = middle.yaw;
  double best_change = kTwoPi;
  for (int first = 0; first < kYaws; ++first) {
    if (!free[static_cast<std::size_t>(first)] || free[static_cast<std::size_t>((first + kYaws - 1) % kYaws)])
      continue;
    int count = 1;
    while (count < kYaws && free[static_cast<std::size_t>((first + count) % kYaws)]) ++count;
    const double change = wrap_angle(kTwoPi * (first + 0.5 * (count - 1)) / kYaws);
    if (std::abs(change) >= best_change) continue;
    best_change = std::abs(change);
    best = middle.yaw + change;
  }
  return best;
}

FootprintRefiner::Status FootprintRefiner::replace(std::vector<Pose2>& poses, const Span& span,
                                                   Pose2& where) const {
  const FootprintCheck check{[this](const Pose2& pose) { return is_free(pose); },
                             [this](const Pose2& from, const Pose2& to) { return passes(from, to); },
                             footprint_.circumscribed_radius_m()};
  const double yaw = aligned_yaw(poses, span);
  where = poses[span.first];
  for (const Reach& reach : kReaches) {
    const Span wide = widened(poses, span, reach.margin_m);
    const std::vector<Pose2> along(poses.begin() + static_cast<std::ptrdiff_t>(wide.first),
                                   poses.begin() + static_cast<std::ptrdiff_t>(wide.last) + 1);
    const double step_m = std::min(costs_.resolution_m, kMaxStep_m) / reach.steps_per_cell;
    const PoseLattice lattice{reach.half_width_m, step_m, reach.yaws,
                              reach.from_first_yaw ? along.front().yaw : yaw};
    PoseSearch search(costs_, traversal_, base_, lattice, check);
    const PoseSearch::Status status = search.find(along, clock_);
    if (status == PoseSearch::Status::kInterrupted) return Status::kInterrupted;
    if (status == PoseSearch::Status::kNoPath) {
      where = along[std::min(search.progress() + 1, along.size() - 1)];
      continue;
    }
    const std::vector<Pose2> passage = densify(straightened(search.poses()));
    poses.erase(poses.begin() + static_cast<std::ptrdiff_t>(wide.first),
                poses.begin() + static_cast<std::ptrdiff_t>(wide.last) + 1);
    poses.insert(poses.begin() + static_cast<std::ptrdiff_t>(wide.first), passage.begin(), passage.end());
    return Status::kFree;
  }
  return Status::kBlocked;
}

/// Straight motions instead of the lattice's steps, over at most 0.4 m.
std::vector<Pose2> FootprintRefiner::straightened(const std::vector<Pose2>& poses) const {
  constexpr double kMax_m = 0.4;
  if (base_ == BaseKind::kDifferential) return poses;
  std::vector<Pose2> out{poses.front()};
  for (std::size_t at = 0; at + 1 < poses.size();) {
    std::size_t to = at + 1;
    while (to + 1 < poses.size() && apart_m(poses[at], poses[to + 1]) <= kMax_m) ++to;
    while (to > at + 1 && !passes(poses[at], poses[to])) to = at + (to - at) / 2;
    out.push_back(poses[to]);
    at = to;
  }
  return out;
}

FootprintRefiner::Refined FootprintRefiner::refine(std::vector<Pose2> poses) const {
  // A passage may begin before contacts that were found earlier, so all is checked again until nothing
  // touches.
  constexpr int kMaxPassages = 200;
  std::size_t end = poses.size();
  for (int passages = 0; passages < kMaxPassages; ++passages) {
    if (clock_.ended()) return {Status::kInterrupted, {}};
    const auto span = last_contact(poses, end);
    if (!span && end == poses.size()) return {Status::kFree, std::move(poses)};
    if (!span) {
      end = poses.size();
      continue;
    }
    Pose2 where;
    const Status status = replace(poses, *span, where);
    if (status != Status::kFree) return {status, {}, where};
    end = std::min(span->last + 1, poses.size());
  }
  return {Status::kBlocked, {}, poses.back()};
}

}  // namespace extperfc::navigate
