#include "mapping/submap_matcher.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/LU>

#include "mapping/matcher.hpp"
#include "mapping/path_filter_common.hpp"
#include "mapping/visibility.hpp"

namespace extperfc::mapping {

namespace {

// Search.
constexpr double kMinScore = 0.5;
constexpr int kMaxNodes = 60'000;
constexpr std::size_t kPeaks = 3;
// Verification.
constexpr double kReachM = 0.4;
constexpr double kAlongM = 1.0;  // searched along a corridor
constexpr double kMinFit = 0.4;
constexpr double kFloorM = 0.02;  // standard deviation of errors inside submaps
constexpr double kFloorRad = 0.005;
// Memory.
constexpr std::size_t kMaxRemembered = 50'000;  // pairs of submaps
constexpr std::size_t kMaxStarts = 16;          // of verifications of a pair

bool is_same_window(const SearchWindow& now, const SearchWindow& then) {
  constexpr double kAlikeM = 0.01;
  constexpr double kAlikeRad = 0.003;
  return near(now.centre, then.centre, kAlikeM, kAlikeRad) &&
         std::abs(now.half_width_m - then.half_width_m) < kAlikeM &&
         std::abs(now.half_yaw_rad - then.half_yaw_rad) < kAlikeRad;
}

}  // namespace

bool SubmapMatcher::SubmapPair::stands_as(const SubmapPair& then) const {
  return is_unchanged(old, then.old) && is_unchanged(seen, then.seen);
}

SubmapMatcher::SubmapPair SubmapMatcher::pair_of(const Ends& ends, const PoseGraph& graph) {
  const auto& poses = graph.poses();
  return {SubmapCache::shape_of(ends.first, poses.size(), poses),
          SubmapCache::shape_of(ends.second, poses.size(), poses)};
}

std::vector<FoundPose> SubmapMatcher::search(const Ends& ends, const SearchWindow& window,
                                             const std::vector<KeyFrame>& frames, const PoseGraph& graph) {
  const SubmapPair submaps = pair_of(ends, graph);
  const auto known = searches_.find(ends);
  if (known != searches_.end() && submaps.stands_as(known->second.submaps) &&
      is_same_window(window, known->second.window))
    return known->second.found;
  if (searches_.size() > kMaxRemembered) searches_.clear();
  auto found = search_anew(ends, window, frames, graph);
  searches_[ends] = {submaps, window, found};
  return found;
}

std::vector<FoundPose> SubmapMatcher::search_anew(const Ends& ends, const SearchWindow& window,
                                                  const std::vector<KeyFrame>& frames,
                                                  const PoseGraph& graph) {
  Submap& old = submaps_.at(ends.first, frames.size(), frames, graph.poses());
  if (!old.pyramid) old.pyramid = std::make_unique<SearchPyramid>(old.map);
  const Submap& seen = submaps_.at(ends.second, frames.size(), frames, graph.poses());
  return search_peaks(*old.pyramid, seen.points, window, kMinScore, kMaxNodes,
                      {kPeaks, kPeakApartM, kPeakApartRad, 0.2});
}

std::optional<SubmapClosure> SubmapMatcher::verify(const Ends& ends, const Pose2& start,
                                                   const std::vector<KeyFrame>& frames,
                                                   const PoseGraph& graph) {
  const SubmapPair submaps = pair_of(ends, graph);
  if (verifications_.size() > kMaxRemembered) verifications_.clear();
  auto& known = verifications_[ends];
  const auto is_out_of_date = [&](const Verification& verification) {
    return !submaps.stands_as(verification.submaps);
  };
  known.erase(std::remove_if(known.begin(), known.end(), is_out_of_date), known.end());
  const auto same = std::find_if(known.begin(), known.end(), [&](const Verification& verification) {
    return stands_still(start, verification.start);
  });
  if (same != known.end()) return same->closure;
  if (known.size() >= kMaxStarts) known.erase(known.begin());
  auto closure = verify_anew(ends, start, frames, graph);
  known.push_back({submaps, start, closure});
  return closure;
}

std::optional<SubmapClosure> SubmapMatcher::verify_anew(const Ends& ends, const Pose2& start,
                                                        const std::vector<KeyFrame>& frames,
                                                        const PoseGraph& graph) {
  const auto [reference, query] = ends;
  const Submap& old = submaps_.at(reference, frames.size(), frames, graph.poses());
  const Submap& seen = submaps_.at(query, frames.size(), frames, graph.poses());
  const PosePrior prior{start, 0.4, 0.15};
  ScanMatch found = match(old.map, seen.points, start, prior, kReachM);
  const auto support = [&](const Pose2& pose) {
    const Agreement forward = agreement(old.map, seen.points, pose);
    const Agreement backward = agreement(seen.map, old.points, inverse(pose));
    return (forward.on_surface - (forward.near_surface - forward.on_surface)) / std::max(1.0, forward.all) -
           (backward.near_surface - backward.on_surface) / std::max(1.0, backward.near_surface) -
           kContradictionCost * contradictions(old, seen, pose);
  };
  if (found.fit < kMinFit) return std::nullopt;
  const auto place = [&](const Pose2& pose) {
    return agreement(old.map, seen.points, pose).ratio() +
           agreement(seen.map, old.points, inverse(pose)).ratio() -
           kContradictionCost * contradictions(old, seen, pose);
  };
  found = match_along(old.map, seen.points, found, prior, kAlongM, kReachM, place);
  SubmapClosure closure;
  closure.support = support(found.pose);
  closure.constraint = {reference,  query,
                        found.pose, Eigen::Matrix3d::Zero(),
                        true,       found.fit - kContradictionCost * contradictions(old, seen, found.pose)};
  if (closure.constraint.fit < kMinFit) return std::nullopt;
  Eigen::Matrix3d covariance = (found.information + 1e-2 * Eigen::Matrix3d::Identity()).inverse();
  covariance.diagonal() += Eigen::Vector3d(kFloorM * kFloorM, kFloorM * kFloorM, kFloorRad * kFloorRad);
  closure.constraint.information = covariance.inverse();
  return closure;
}

}  // namespace extperfc::mapping
