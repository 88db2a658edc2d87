// Matches the newest key frame to old submaps.
#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "mapping/path_filter.hpp"
#include "mapping/path_filter_common.hpp"

namespace extperfc::mapping {

namespace {

// Younger key frames belong to the tracker's local map.
constexpr double kOldAfterM = 6.0;
constexpr std::size_t kOldAfterFrames = 24;
constexpr double kSubmapRadiusM = 4.0;  // an old key frame this near has much the same view
constexpr std::size_t kSubmapsPerParticle = 2;
constexpr double kWidestSlideM = 1.2;  // along a corridor
constexpr double kSameStartM = 0.08;   // particles nearer than this share one match
constexpr double kSameStartRad = 0.02;
constexpr double kBasinM = 0.2;  // around a good match, from where others lead to the same pose
constexpr double kBasinRad = 0.08;
// Standard deviations of how far a match may pull a particle: the first one may close the gaps between
// particles.
constexpr double kFirstPullM = 0.2;
constexpr double kPullM = 0.06;
constexpr double kFirstPullRad = 0.08;
constexpr double kPullRad = 0.04;
constexpr std::size_t kMaxCandidates = 24;  // kept per particle
constexpr double kFarthestDrifts = 4.0;     // standard deviations: offsets beyond are rejected
// Wide searches.
constexpr double kFarWindowM = 2.0;  // at least
constexpr double kWidestWindowM = 15.0;
constexpr double kFarScore = 0.75;
constexpr int kFarNodes = 20000;
constexpr double kFarFit = 0.65;

/// Log likelihood of a match that pulled a particle from `from` to `to`.
double pull_cost(const Pose2& from, const Pose2& to, bool first) {
  const double m = std::hypot(from.x - to.x, from.y - to.y) / (first ? kFirstPullM : kPullM);
  const double rad = wrap_angle(from.yaw - to.yaw) / (first ? kFirstPullRad : kPullRad);
  return -0.5 * (m * m + rad * rad);
}

void keep_newest(std::vector<LoopClosureCandidate>& candidates) {
  if (candidates.size() > kMaxCandidates)
    candidates.erase(candidates.begin(), candidates.end() - static_cast<std::ptrdiff_t>(kMaxCandidates));
}

}  // namespace

/// A match of the newest key frame in an old submap.
struct PathFilter::SubmapMatch {
  Pose2 pose;  ///< in the map
  LoopClosureCandidate candidate;
};

std::size_t PathFilter::old_end() const {
  if (frames_.size() <= kOldAfterFrames) return 0;
  std::size_t end = frames_.size() - kOldAfterFrames;
  while (end > 0 && frames_.back().travelled_m - frames_[end - 1].travelled_m < kOldAfterM) --end;
  return end;
}

std::vector<std::size_t> PathFilter::old_key_frames_near(const Pose2& pose, double radius_m,
                                                         std::size_t max_count) const {
  std::vector<std::pair<double, std::size_t>> near_frames;
  const std::size_t end = old_end();
  for (std::size_t i = 0; i < end; ++i) {
    if (parts_[i] != parts_.back() || frames_[i].is_thinned()) continue;
    const double away = distance(graph_.poses()[i], pose);
    if (away < radius_m) near_frames.emplace_back(away, i);
  }
  return nearest_of_passes(std::move(near_frames), max_count);
}

std::optional<PathFilter::SubmapMatch> PathFilter::match_submap(std::size_t submap_frame, const Pose2& pose,
                                                                double sigma_m, double sigma_rad) {
  if (distance(pose, graph_.poses().back()) > farthest_offset_m(submap_frame)) return std::nullopt;
  Submap& submap = submaps_.at(submap_frame, old_end(), frames_, graph_.poses());
  const Pose2& middle = graph_.poses()[submap_frame];
  const Pose2 start = between(middle, pose);
  const PosePrior prior{start, sigma_m, sigma_rad};
  const ScanPoints& points = frames_.back().points;
  auto seen = match(submap.map, points, start, prior, kMatchReachM);
  const double window = std::min(kWidestSlideM, 0.3 + 2 * expected_drift_m());
  if (seen.fit >= kGoodFit) {
    const double overlap =
        agreement(submap.map, points, start).near_surface / static_cast<double>(points.surface.size());
    seen = match_along(submap.map, points, seen, prior, window, kMatchReachM, [&](const Pose2& there) {
      return overlap * agreement(submap.map, points, there).ratio() -
             kContradictionCost * contradictions(submap, points, *profile_, there);
    });
  }
  seen.fit -= kContradictionCost * contradictions(submap, points, *profile_, seen.pose);
  SubmapMatch found;
  found.pose = compose(middle, seen.pose);
  found.candidate.fit = seen.fit;
  if (!near(found.pose, pose, kFarthestPullM + window, kFarthestPullRad)) return std::nullopt;
  // Errors inside the submap, which the match does not observe.
  constexpr double kFloorM = 0.008;
  constexpr double kFloorRad = 0.003;
  Eigen::Matrix3d covariance = (seen.information + 1e-2 * Eigen::Matrix3d::Identity()).inverse();
  covariance.diagonal() += Eigen::Vector3d(kFloorM * kFloorM, kFloorM * kFloorM, kFloorRad * kFloorRad);
  found.candidate.constraint = {submap_frame, frames_.size() - 1, seen.pose, covariance.inverse(), true};
  return found;
}

/// Whether a submap fits.
bool PathFilter::match_to_submaps(Particle& particle) {
  const auto submaps = old_key_frames_near(particle.pose, kSubmapRadiusM, kSubmapsPerParticle);
  if (submaps.empty()) return false;
  double best_fit = 0;
  const Pose2 predicted = particle.pose;
  const bool first = particle.candidates.empty();
  for (const std::size_t submap : submaps) {
    // Every match starts from the predicted pose, independent of the others.
    const auto seen = match_submap(submap, predicted, kMatchSigmaM, kMatchSigmaRad);
    if (!seen) continue;
    if (seen->candidate.fit > best_fit) {
      best_fit = seen->candidate.fit;
      if (best_fit >= kGoodFit) particle.pose = seen->pose;
    }
    if (seen->candidate.fit >= kGoodFit) particle.candidates.push_back(seen->candidate);
  }
  keep_newest(particle.candidates);
  particle.log_weight += kWeightGain * (best_fit - 0.5) + pull_cost(predicted, particle.pose, first);
  return best_fit >= kGoodFit;
}

/// Particles with nearly the same pose share one match, and those around a pose that the scan fits well share
/// it: their own matches would end there.
void PathFilter::find_loop_closures() {
  struct Done {
    Pose2 start;  ///< of the match
    std::size_t particle;
    bool good;
  };
  std::vector<Done> done;
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    Particle& particle = particles_[i];
    const auto same = std::find_if(done.begin(), done.end(), [&](const Done& other) {
      return near(other.start, particle.pose, kSameStartM, kSameStartRad) ||
             (other.good && near(particles_[other.particle].pose, particle.pose, kBasinM, kBasinRad));
    });
    if (same == done.end()) {
      const Pose2 start = particle.pose;
      const bool good = match_to_submaps(particle);
      done.push_back({start, i, good});
      continue;
    }
    const Particle& example = particles_[same->particle];
    const std::size_t newest = frames_.size() - 1;
    double best_fit = -1;
    for (const LoopClosureCandidate& candidate : example.candidates)
      if (candidate.constraint.to == newest) {
        particle.candidates.push_back(candidate);
        best_fit = std::max(best_fit, candidate.fit);
      }
    if (best_fit < 0) {
      if (!old_key_frames_near(particle.pose, kSubmapRadiusM, 1).empty())
        particle.log_weight += kWeightGain * -0.2;
      continue;
    }
    const bool first = particle.candidates.back().constraint.to == newest &&
                       particle.candidates.size() <= kSubmapsPerParticle;
    particle.log_weight += kWeightGain * (best_fit - 0.5) + pull_cost(particle.pose, example.pose, first);
    particle.pose = example.pose;
    keep_newest(particle.candidates);
  }
}

double PathFilter::expected_drift_m() const {
  const double travelled_m = frames_.back().travelled_m - accepted_at_m_;
  return 0.05 + kDriftPerM * travelled_m;
}

/// Maximum offset of the newest key frame against a submap: the drift since the last accepted loop closure or
/// since the robot was at that submap, whichever is less.
double PathFilter::farthest_offset_m(std::size_t submap) const {
  const double since_submap = frames_.back().travelled_m - frames_[submap].travelled_m;
  const double travelled_m = std::min(since_submap, frames_.back().travelled_m - accepted_at_m_);
  return kFarthestPullM + kFarthestDrifts * kDriftPerM * travelled_m;
}

/// Searches the newest key frame in one old submap per call, beyond the reach of the particles.
void PathFilter::search_far() {
  const double window = std::min(kWidestWindowM, std::max(kFarWindowM, 2.5 * expected_drift_m()));
  const Pose2 middle = graph_.poses().back();
  const auto submaps = old_key_frames_near(middle, window + kSubmapRadiusM, 8);
  if (submaps.empty()) return;
  const std::size_t frame = submaps[next_far_++ % submaps.size()];
  Submap& submap = submaps_.at(frame, old_end(), frames_, graph_.poses());
  if (!submap.pyramid) submap.pyramid = std::make_unique<SearchPyramid>(submap.map);
  const Pose2 centre = between(graph_.poses()[frame], middle);
  const double half_yaw_rad = std::min(0.6, 0.15 + 0.03 * expected_drift_m());
  const auto found = search_wide(*submap.pyramid, frames_.back().points, {centre, window, half_yaw_rad},
                                 kFarScore, kFarNodes);
  if (!found) return;
  const auto seen = match_submap(frame, compose(graph_.poses()[frame], found->pose), 0.5, 0.2);
  if (seen && seen->candidate.fit >= kFarFit) inject(*seen);
}

/// Replaces the least likely particle by a pose of the wide search, with an average weight.
void PathFilter::inject(const SubmapMatch& found) {
  const bool known = std::any_of(particles_.begin(), particles_.end(), [&](const Particle& particle) {
    return near(particle.pose, found.pose, kSameClusterM, kSameClusterRad) && !particle.candidates.empty();
  });
  if (known || particles_.size() < 2) {
    if (particles_.size() == 1 && particles_.front().candidates.empty()) {
      particles_.front().pose = found.pose;
      particles_.front().candidates.assign(1, found.candidate);
      particles_.front().injected = true;
    }
    return;
  }
  const auto worst = std::min_element(particles_.begin(), particles_.end(), [](const auto& a, const auto& b) {
    return a.log_weight < b.log_weight;
  });
  double mean = 0;
  for (const Particle& particle : particles_)
    mean += particle.log_weight / static_cast<double>(particles_.size());
  *worst = Particle{found.pose, mean, {found.candidate}, true};
}

}  // namespace extperfc::mapping
