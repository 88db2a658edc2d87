#include "mapping/pass_matcher.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "mapping/matcher.hpp"
#include "mapping/path_filter_common.hpp"
#include "mapping/visibility.hpp"

namespace extperfc::mapping {

namespace {

constexpr double kMinFineFit = 0.6;

/// How much better, or worse, than by chance key frames fit the submaps that they were matched in.
double score_of(const std::vector<Constraint>& matches) {
  constexpr double kIndifferentFit = 0.4;
  double score = 0;
  for (const Constraint& match : matches) score += std::clamp(match.fit - kIndifferentFit, -0.5, 0.5);
  return score;
}

}  // namespace

/// Old key frames about `query` at its present pose, one of each pass, the nearest first.
std::vector<std::size_t> PassMatcher::passes(std::size_t query, const std::vector<KeyFrame>& frames,
                                             const std::vector<Pose2>& poses) const {
  constexpr std::size_t kMaxPasses = 2;
  std::vector<std::pair<double, std::size_t>> found;
  for (std::size_t i = 0; i + kMinLoopFrames < query; i += 2) {
    if (frames[query].travelled_m - frames[i].travelled_m < kMinLoopM) break;
    const double away = distance(poses[i], poses[query]);
    if (away < kOverlapM && !frames[i].is_thinned()) found.emplace_back(away, i);
  }
  return nearest_of_passes(std::move(found), kMaxPasses);
}

/// Matches one scan in an old submap, from where it stands.
Constraint PassMatcher::match_scan(std::size_t reference, std::size_t query,
                                   const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses) {
  constexpr double kFloorM = 0.008;
  constexpr double kFloorRad = 0.003;
  constexpr double kReachM = 0.25;
  constexpr double kWindowM = 0.3;
  // Along a corridor a single scan may be pulled by returns at a grazing angle: neighbours decide there.
  constexpr double kWeakRatio = 0.15;
  constexpr double kAlongM = 0.03;
  constexpr double kOppositeM = 0.05;  // seen from the other side, recesses show other walls
  constexpr double kOppositeRad = 1.5;
  const Submap& submap = submaps_.at(reference, query, frames, poses);
  const Pose2 start = between(poses[reference], poses[query]);
  const ScanPoints& points = frames[query].points;
  const RangeProfile profile(points);
  const PosePrior prior{start, 0.15, 0.06};
  auto seen = match(submap.map, points, start, prior, kReachM);
  if (seen.fit >= kMinFineFit) {
    const double overlap =
        agreement(submap.map, points, start).near_surface / static_cast<double>(points.surface.size());
    seen = match_along(submap.map, points, seen, prior, kWindowM, kReachM, [&](const Pose2& there) {
      return overlap * agreement(submap.map, points, there).ratio() -
             kContradictionCost * contradictions(submap, points, profile, there);
    });
  }
  Eigen::Matrix3d covariance = (seen.information + 1e-2 * Eigen::Matrix3d::Identity()).inverse();
  covariance.diagonal() += Eigen::Vector3d(kFloorM * kFloorM, kFloorM * kFloorM, kFloorRad * kFloorRad);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(seen.information.topLeftCorner<2, 2>());
  if (axes.eigenvalues()[0] < kWeakRatio * axes.eigenvalues()[1]) {
    const Eigen::Vector2d along = axes.eigenvectors().col(0);
    const double sigma_m = std::abs(seen.pose.yaw) > kOppositeRad ? kOppositeM : kAlongM;
    covariance.topLeftCorner<2, 2>() += sigma_m * sigma_m * along * along.transpose();
  }
  const double fit = seen.fit - kContradictionCost * contradictions(submap, points, profile, seen.pose);
  return {reference, query, seen.pose, covariance.inverse(), true, fit};
}

Constraint PassMatcher::remembered_match(std::size_t reference, std::size_t query,
                                         const std::vector<KeyFrame>& frames,
                                         const std::vector<Pose2>& poses) {
  constexpr std::size_t kMaxPerFrame = 8;
  const Pose2 start = between(poses[reference], poses[query]);
  const SubmapShape submap = SubmapCache::shape_of(reference, query, poses);
  const auto known = matches_.find({reference, query});
  if (known != matches_.end() && stands_still(start, known->second.start) &&
      is_unchanged(submap, known->second.submap))
    return known->second.constraint;
  if (matches_.size() > kMaxPerFrame * frames.size()) matches_.clear();
  Constraint constraint = match_scan(reference, query, frames, poses);
  matches_[{reference, query}] = {constraint, start, submap};
  return constraint;
}

/// Every key frame in the old submaps about it.
std::vector<Constraint> PassMatcher::match_all(const std::vector<KeyFrame>& frames,
                                               const std::vector<Pose2>& poses) {
  std::vector<Constraint> matches;
  for (std::size_t query = kMinLoopFrames; query < frames.size(); ++query) {
    if (frames[query].is_thinned()) continue;
    for (const std::size_t i : passes(query, frames, poses))
      matches.push_back(remembered_match(i / 4 * 4 + 2, query, frames, poses));  // neighbours: one submap
  }
  return matches;
}

double PassMatcher::score(const std::vector<KeyFrame>& frames, const PoseGraph& graph) {
  return score_of(match_all(frames, graph.poses()));
}

double PassMatcher::refine(const std::vector<KeyFrame>& frames, PoseGraph& graph) {
  constexpr int kRounds = 2;
  constexpr double kFarthestM = 0.35;
  constexpr double kFarthestRad = 0.12;
  const std::size_t coarse = graph.constraints().size();
  double score = 0;
  for (int round = 0; round < kRounds; ++round) {
    const auto matches = match_all(frames, graph.poses());
    score = score_of(matches);
    graph.constraints().resize(coarse);
    for (const Constraint& match : matches) {
      const Pose2 start = between(graph.poses()[match.from], graph.poses()[match.to]);
      if (match.fit >= kMinFineFit && near(match.from_T_to, start, kFarthestM, kFarthestRad))
        graph.add(match);
    }
    graph.optimize(0, kGraphIterations);
  }
  return score;
}

}  // namespace extperfc::mapping
