#include "navigate/global/footprint_refiner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "extperfc/base/math.hpp"
#include "extperfc/navigate/path.hpp"

#include "navigate/global/passage_line.hpp"
#include "navigate/global/path_shape.hpp"
#include "navigate/global/pose_search.hpp"
#include "navigate/global/steered_path.hpp"

namespace extperfc::navigate {

namespace {

/// How far a search for a passage reaches: along the path beyond the contact, and to both sides.
struct SearchExtent {
  double margin_m;
  double half_width_m;
  double steps_per_cell;
  int yaws;
  bool from_first;  ///< the lattice holds the first pose, not the one in the middle of the passage
};
constexpr std::array<SearchExtent, 4> kReaches{
    {{0.5, 0.3, 1, 48, false}, {1.0, 0.4, 2, 64, false}, {1.0, 0.4, 2, 64, true}, {2.0, 1.0, 1, 64, false}}};
constexpr double kApart_m = 0.6;  // contacts nearer to each other are one
constexpr double kMaxStep_m = 0.05;

constexpr double kMaxAcross_m = 1.0;  // of a line across the path

constexpr std::array<double, 3> kPaddings_m{0.05, 0.03, 0};  // of a differential base, the first that passes
constexpr double kMaxAcross_rad = 1.2;  // of a differential base, from the path's direction
constexpr double kCentred_m = 1.6;      // longest narrow place that is passed straight
constexpr double kMaxDetour_m = 0.5;    // of that
constexpr double kPassage_m = 0.7;      // shortest straight motion through one
constexpr double kBeside_m = 1.0;       // of the path beyond a narrow place, which goes with it

/// First index and length of the longest run of true in a circle.
template <std::size_t kCount>
std::pair<int, int> longest_run(const std::array<bool, kCount>& values) {
  std::pair<int, int> longest{0, 0};
  int run = 0;
  for (int k = 0; k < 2 * static_cast<int>(kCount); ++k) {
    run = values[static_cast<std::size_t>(k) % kCount] ? std::min(run + 1, static_cast<int>(kCount)) : 0;
    if (run > longest.second) longest = {k - run + 1, run};
  }
  return longest;
}

}  // namespace

FootprintRefiner::FootprintRefiner(const CostGrid& costs, const Footprint& footprint,
                                   const Traversal& traversal, BaseKind base, const PlanClock& clock)
    : costs_(costs), footprint_(footprint), traversal_(traversal), base_(base), clock_(clock) {
  if (base_ == BaseKind::kDifferential)
    for (const double padding_m : kPaddings_m)
      padded_.push_back(padding_m > 0 ? footprint.padded(padding_m) : footprint);
}

bool FootprintRefiner::is_free(const Pose2& pose) const {
  return is_free(footprint_, pose);
}

bool FootprintRefiner::is_free_along(const Pose2& from, const Pose2& to) const {
  return is_free_along(footprint_, from, to);
}

bool FootprintRefiner::is_free(const Footprint& footprint, const Pose2& pose) const {
  const Contact touched = contact(costs_, footprint, pose);
  return touched == Contact::kFree || (touched == Contact::kUnknown && traversal_.admits(kUnknownCost));
}

bool FootprintRefiner::is_free_along(const Footprint& footprint, const Pose2& from, const Pose2& to) const {
  if (!traversal_.admits(kUnknownCost)) return contact_along(costs_, footprint, from, to) == Contact::kFree;
  const double yaw = wrap_angle(to.yaw - from.yaw);
  const double motion_m = distance_m(from, to) + std::abs(yaw) * footprint.circumscribed_radius_m();
  const double steps = std::max(1.0, std::ceil(motion_m / (0.5 * costs_.resolution_m)));
  for (double k = 0; k <= steps; ++k) {
    const double part = k / steps;
    if (!is_free(footprint,
                 {from.x + part * (to.x - from.x), from.y + part * (to.y - from.y), from.yaw + part * yaw}))
      return false;
  }
  return true;
}

bool FootprintRefiner::passes(const Footprint& footprint, const Pose2& from, const Pose2& to) const {
  const std::vector<Pose2> poses = densify({from, to});
  for (std::size_t i = 1; i < poses.size(); ++i)
    if (!is_free_along(footprint, poses[i - 1], poses[i])) return false;
  return true;
}

/// The last poses, before `end`, on or between which the footprint touches.
std::optional<FootprintRefiner::Span> FootprintRefiner::last_contact(const Footprint& footprint,
                                                                     const std::vector<Pose2>& poses,
                                                                     std::size_t end) const {
  std::optional<Span> span;
  for (std::size_t i = end; i-- > 1;) {
    if (span && distance_m(poses[i], poses[span->first]) > kApart_m) break;
    if (is_free_along(footprint, poses[i - 1], poses[i])) continue;
    span = Span{i - 1, span ? span->last : i};
  }
  return span;
}

FootprintRefiner::Span FootprintRefiner::widened(const std::vector<Pose2>& poses, const Span& span,
                                                 double margin_m) const {
  Span wide = span;
  for (double passed_m = 0; wide.first > 0; --wide.first) {
    if (passed_m >= margin_m && is_free(poses[wide.first])) break;
    passed_m += std::max(1e-3, distance_m(poses[wide.first], poses[wide.first - 1]));
  }
  for (double passed_m = 0; wide.last + 1 < poses.size(); ++wide.last) {
    if (passed_m >= margin_m && is_free(poses[wide.last])) break;
    passed_m += std::max(1e-3, distance_m(poses[wide.last], poses[wide.last + 1]));
  }
  return wide;
}

std::optional<Pose2> FootprintRefiner::freest_across(const Pose2& pose, double direction) const {
  constexpr int kYaws = 120;
  const double step_m = 0.25 * std::min(costs_.resolution_m, kMaxStep_m);
  const Eigen::Vector2d across(-std::sin(direction), std::cos(direction));
  std::optional<Pose2> best;
  int best_run = 0;
  for (const int side : {1, -1})
    for (int k = side > 0 ? 0 : 1; k * step_m <= kMaxAcross_m && best_run < kYaws; ++k) {
      const Eigen::Vector2d at = Eigen::Vector2d(pose.x, pose.y) + side * k * step_m * across;
      const auto cell = costs_.cell_of(at);
      if (!cell || !traversal_.admits(costs_.at(*cell))) {
        if (k * step_m > costs_.resolution_m) break;
        continue;  // the pose may lie on the edge of such a cell
      }
      std::array<bool, kYaws> free{};
      for (int k_yaw = 0; k_yaw < kYaws; ++k_yaw) {
        const double yaw = pose.yaw + kTwoPi * k_yaw / kYaws;
        // A differential base passes with its front ahead.
        if (base_ == BaseKind::kDifferential && std::abs(wrap_angle(yaw - direction)) > kMaxAcross_rad)
          continue;
        free[static_cast<std::size_t>(k_yaw)] = is_free({at.x(), at.y(), yaw});
      }
      const auto [first, run] = longest_run(free);
      if (run <= best_run) continue;
      best_run = run;
      best = Pose2{at.x(), at.y(), wrap_angle(pose.yaw + kTwoPi * (first + 0.5 * (run - 1)) / kYaws)};
    }
  return best;
}

FootprintRefiner::Section FootprintRefiner::narrowest(const std::vector<Pose2>& poses,
                                                      const Span& span) const {
  Section section{false, poses[(span.first + span.last) / 2]};
  for (std::size_t i = span.first; i <= span.last; ++i) {
    const std::size_t before = i < 2 ? 0 : i - 2;
    const std::size_t after = std::min(i + 2, poses.size() - 1);
    const double dx = poses[after].x - poses[before].x;
    const double dy = poses[after].y - poses[before].y;
    if (is_free(poses[i]) || std::hypot(dx, dy) < 1e-6) continue;
    const auto freest = freest_across(poses[i], std::atan2(dy, dx));
    if (!freest) return {true, poses[i]};
    if (i <= (span.first + span.last) / 2 || i == span.first) section.pose = *freest;
  }
  return section;
}

bool FootprintRefiner::is_small() const {
  return footprint_.inscribed_radius_m() < 2 * costs_.resolution_m;
}

std::vector<Pose2> FootprintRefiner::part(const std::vector<Pose2>& poses, const Span& span) {
  return {poses.begin() + static_cast<std::ptrdiff_t>(span.first),
          poses.begin() + static_cast<std::ptrdiff_t>(span.last) + 1};
}

void FootprintRefiner::put(std::vector<Pose2>& poses, const Span& span, const std::vector<Pose2>& passage) {
  const auto first = poses.begin() + static_cast<std::ptrdiff_t>(span.first);
  const auto after = poses.erase(first, poses.begin() + static_cast<std::ptrdiff_t>(span.last) + 1);
  poses.insert(after, passage.begin(), passage.end());
}

FootprintRefiner::Status FootprintRefiner::search(const std::vector<Pose2>& along, const PoseLattice& lattice,
                                                  std::vector<Pose2>& passage, Pose2& where) const {
  const FootprintCheck check{[this](const Pose2& pose) { return is_free(pose); },
                             [this](const Pose2& from, const Pose2& to) { return passes(from, to); },
                             footprint_.circumscribed_radius_m()};
  PoseSearch search(costs_, traversal_, base_, lattice, check);
  const PoseSearch::Status status = search.find(along, clock_);
  if (status == PoseSearch::Status::kInterrupted) return Status::kInterrupted;
  if (status == PoseSearch::Status::kNoPath) {
    where = along[std::min(search.progress() + 1, along.size() - 1)];
    return Status::kBlocked;
  }
  passage = densify(straightened(search.poses()));
  return Status::kFree;
}

FootprintRefiner::Status FootprintRefiner::search_steered(const std::vector<Pose2>& along,
                                                          PoseLattice lattice, const Section& section,
                                                          std::vector<Pose2>& passage, Pose2& where) const {
  if (const auto straight = straight_through(along.front(), section.pose, along.back())) {
    passage = densify(*straight);
    return Status::kFree;
  }
  const auto from = [&](const Pose2& first, double yaw) { lattice.anchor = {first.x, first.y, yaw}; };
  from(along.front(), is_small() ? 0.0 : section.pose.yaw);
  Status status = search(along, lattice, passage, where);
  if (status != Status::kBlocked) return status;
  // Where the footprint cannot rotate, it leaves or reaches an end only with its own heading: the lattice
  // lies along it, and the search begins there.
  from(along.front(), along.front().yaw);
  status = search(along, lattice, passage, where);
  if (status != Status::kBlocked) return status;
  from(along.back(), along.back().yaw);
  lattice.backwards = true;
  Pose2 farthest;  // from the other end
  status = search({along.rbegin(), along.rend()}, lattice, passage, farthest);
  std::reverse(passage.begin(), passage.end());
  return status;
}

FootprintRefiner::Status FootprintRefiner::replace(std::vector<Pose2>& poses, const Span& span,
                                                   Pose2& where) const {
  const Section section = narrowest(poses, span);
  where = section.pose;
  if (section.closed && !is_small()) return Status::kBlocked;
  for (const SearchExtent& reach : kReaches) {
    const Span wide = widened(poses, span, reach.margin_m);
    const std::vector<Pose2> along = part(poses, wide);
    PoseLattice lattice;
    lattice.half_width_m = reach.half_width_m;
    lattice.step_m = std::min(costs_.resolution_m, kMaxStep_m) / reach.steps_per_cell;
    lattice.yaws = reach.yaws;
    lattice.anchor = reach.from_first || is_small() ? along.front() : section.pose;
    std::vector<Pose2> passage;
    Status status = Status::kBlocked;
    if (base_ != BaseKind::kDifferential)
      status = search(along, lattice, passage, where);
    else if (!reach.from_first)  // such a base's lattice always does
      status = search_steered(along, lattice, section, passage, where);
    if (status == Status::kInterrupted) return status;
    if (status == Status::kBlocked) continue;
    put(poses, wide, passage);
    return Status::kFree;
  }
  return Status::kBlocked;
}

std::optional<std::vector<Pose2>> FootprintRefiner::straight_through(const Pose2& first, const Pose2& middle,
                                                                     const Pose2& last) const {
  const double reach_m =
      0.5 * (kPassage_m + footprint_.inscribed_radius_m() + footprint_.circumscribed_radius_m());
  const auto is_blocked = [this](Cost cost) {
    return cost == kLethalCost || (cost == kUnknownCost && !traversal_.admits(cost));
  };
  const Pose2 widest = widest_line(costs_, is_blocked, middle, reach_m);
  for (const Footprint& narrow : padded_)
    for (const Pose2& line : {widest, middle}) {
      auto passage = straight_passage(
          first, line, last, [&](const Pose2& from, const Pose2& to) { return passes(from, to); },
          [&](const Pose2& from, const Pose2& to) { return passes(padded_.front(), from, to); },
          [&](const Pose2& from, const Pose2& to) { return passes(narrow, from, to); });
      if (passage) return passage;
    }
  return std::nullopt;
}

std::vector<Pose2> FootprintRefiner::centred(std::vector<Pose2> poses) const {
  std::size_t end = poses.size();
  while (const auto span = last_contact(padded_.front(), poses, end)) {
    if (clock_.ended()) break;
    end = std::max<std::size_t>(1, span->first);
    if (distance_m(poses[span->first], poses[span->last]) > kCentred_m) continue;
    const Span wide = widened(poses, *span, kBeside_m);
    const double direction =
        std::atan2(poses[span->last].y - poses[span->first].y, poses[span->last].x - poses[span->first].x);
    const auto freest = freest_across(poses[(span->first + span->last) / 2], direction);
    if (!freest) continue;
    const std::vector<Pose2> along = part(poses, wide);
    const auto passage = straight_through(along.front(), *freest, along.back());
    if (!passage || length_m({*passage, 0}) > length_m({along, 0}) + kMaxDetour_m) continue;
    put(poses, wide, densify(*passage));
    end = std::min(end, poses.size());
  }
  return poses;
}

/// Straight motions instead of the lattice's steps, over at most 0.4 m.
std::vector<Pose2> FootprintRefiner::straightened(const std::vector<Pose2>& poses) const {
  constexpr double kMax_m = 0.4;
  if (base_ == BaseKind::kDifferential) return poses;
  std::vector<Pose2> out{poses.front()};
  for (std::size_t at = 0; at + 1 < poses.size();) {
    std::size_t to = at + 1;
    while (to + 1 < poses.size() && distance_m(poses[at], poses[to + 1]) <= kMax_m) ++to;
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
  const bool steered = base_ == BaseKind::kDifferential;
  if (steered) poses = centred(std::move(poses));
  std::size_t end = poses.size();
  for (int passages = 0; passages < kMaxPassages; ++passages) {
    if (clock_.ended()) return {Status::kInterrupted, {}};
    const auto span = last_contact(footprint_, poses, end);
    if (!span && end == poses.size() && !steered) return {Status::kFree, std::move(poses)};
    if (!span && end == poses.size())
      return {Status::kFree, densify(round_corners(poses, [this](const Pose2& from, const Pose2& to) {
                return passes(padded_.front(), from, to);
              }))};
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
