// Where particles look for the newest key frame among old places.
#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "mapping/path_filter.hpp"
#include "mapping/path_filter_common.hpp"

namespace extperfc::mapping {

namespace {

// Places younger than this are the tracker's business.
constexpr double kOldAfterM = 6.0;
constexpr std::size_t kOldAfterFrames = 24;
constexpr double kSightRadiusM = 4.0;  // an old key frame so near sees much the same
constexpr std::size_t kPlacesPerSight = 2;
constexpr std::size_t kOtherPass = 30;  // key frames apart: another pass of the same place
constexpr double kWidestSlideM = 1.2;   // along a corridor
constexpr double kWeightGain = 6.0;     // log weight per key frame and unit of fit
constexpr double kSameStartM = 0.08;    // particles nearer than this share one match
constexpr double kSameStartRad = 0.02;
// Standard deviations of how far a match may pull a particle: the first one may close the gaps between
// particles.
constexpr double kFirstPullM = 0.2;
constexpr double kPullM = 0.06;
constexpr double kFirstPullRad = 0.08;
constexpr double kPullRad = 0.04;
constexpr std::size_t kMostSightings = 24;  // kept per particle
constexpr double kFarthestDrifts = 4.0;     // standard deviations: nothing that far is believed
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

void keep_newest(std::vector<Sighting>& sightings) {
  if (sightings.size() > kMostSightings)
    sightings.erase(sightings.begin(), sightings.end() - static_cast<std::ptrdiff_t>(kMostSightings));
}

}  // namespace

/// A match of the newest key frame in an old place.
struct PathFilter::Candidate {
  Pose2 pose;  ///< in the map
  Sighting sighting;
};

std::size_t PathFilter::old_end() const {
  if (frames_.size() <= kOldAfterFrames) return 0;
  std::size_t end = frames_.size() - kOldAfterFrames;
  while (end > 0 && frames_.back().travelled_m - frames_[end - 1].travelled_m < kOldAfterM) --end;
  return end;
}

std::vector<std::size_t> PathFilter::old_places_near(const Pose2& pose, double radius_m,
                                                     std::size_t most) const {
  std::vector<std::pair<double, std::size_t>> near_frames;
  const std::size_t end = old_end();
  for (std::size_t i = 0; i < end; ++i) {
    const double away = distance(graph_.poses()[i], pose);
    if (away < radius_m) near_frames.emplace_back(away, i);
  }
  std::sort(near_frames.begin(), near_frames.end());
  std::vector<std::size_t> chosen;
  for (const auto& [away, i] : near_frames) {
    const bool new_pass = std::all_of(chosen.begin(), chosen.end(), [&, i = i](std::size_t other) {
      return (i > other ? i - other : other - i) >= kOtherPass;
    });
    if (new_pass) chosen.push_back(i);
    if (chosen.size() == most) break;
  }
  return chosen;
}

std::optional<PathFilter::Candidate> PathFilter::look_at(std::size_t place_frame, const Pose2& pose,
                                                         double sigma_m, double sigma_rad) {
  if (distance(pose, graph_.poses().back()) > farthest_offset_m(place_frame)) return std::nullopt;
  Place& place = places_.at(place_frame, old_end(), frames_, graph_.poses());
  const Pose2& middle = graph_.poses()[place_frame];
  const Pose2 start = between(middle, pose);
  const PosePrior prior{start, sigma_m, sigma_rad};
  const ScanPoints& points = frames_.back().points;
  auto seen = match(place.map, points, start, prior, kSightReachM);
  const double window = std::min(kWidestSlideM, 0.3 + 2 * expected_drift_m());
  if (seen.fit >= kGoodFit)
    seen = match_along(place.map, points, seen, prior, window, kSightReachM, [&](const Pose2& there) {
      return graded_fit(place.map, points, there) -
             kContradictionCost * contradictions(place, points, *profile_, there);
    });
  seen.fit -= kContradictionCost * contradictions(place, points, *profile_, seen.pose);
  Candidate candidate;
  candidate.pose = compose(middle, seen.pose);
  candidate.sighting.fit = seen.fit;
  if (!near(candidate.pose, pose, kFarthestPullM + window, kFarthestPullRad)) return std::nullopt;
  // What no scan sees: the local map's own bends.
  constexpr double kFloorM = 0.008;
  constexpr double kFloorRad = 0.003;
  Eigen::Matrix3d covariance = (seen.information + 1e-2 * Eigen::Matrix3d::Identity()).inverse();
  covariance.diagonal() += Eigen::Vector3d(kFloorM * kFloorM, kFloorM * kFloorM, kFloorRad * kFloorRad);
  candidate.sighting.relation = {place_frame, frames_.size() - 1, seen.pose, covariance.inverse(), true};
  return candidate;
}

void PathFilter::sight_one(Particle& particle) {
  const auto places = old_places_near(particle.pose, kSightRadiusM, kPlacesPerSight);
  if (places.empty()) return;
  double best_fit = 0;
  const Pose2 predicted = particle.pose;
  const bool first = particle.sightings.empty();
  for (const std::size_t place : places) {
    // All start from where the particle was, so that none inherits another's slide.
    const auto seen = look_at(place, predicted, kSightSigmaM, kSightSigmaRad);
    if (!seen) continue;
    if (seen->sighting.fit > best_fit) {
      best_fit = seen->sighting.fit;
      if (best_fit >= kGoodFit) particle.pose = seen->pose;
    }
    if (seen->sighting.fit >= kGoodFit) particle.sightings.push_back(seen->sighting);
  }
  keep_newest(particle.sightings);
  particle.log_weight += kWeightGain * (best_fit - 0.5) + pull_cost(predicted, particle.pose, first);
}

/// Particles that start alike see alike: one match serves them all.
void PathFilter::sight() {
  std::vector<std::pair<Pose2, std::size_t>> done;  // start of a match, and whose it was
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    Particle& particle = particles_[i];
    const auto same = std::find_if(done.begin(), done.end(), [&](const auto& other) {
      return near(other.first, particle.pose, kSameStartM, kSameStartRad);
    });
    if (same == done.end()) {
      const Pose2 start = particle.pose;
      sight_one(particle);
      done.emplace_back(start, i);
      continue;
    }
    const Particle& example = particles_[same->second];
    const std::size_t newest = frames_.size() - 1;
    double best_fit = -1;
    for (const Sighting& sighting : example.sightings)
      if (sighting.relation.to == newest) {
        particle.sightings.push_back(sighting);
        best_fit = std::max(best_fit, sighting.fit);
      }
    if (best_fit < 0) {
      if (!old_places_near(particle.pose, kSightRadiusM, 1).empty())
        particle.log_weight += kWeightGain * -0.2;
      continue;
    }
    const bool first =
        particle.sightings.back().relation.to == newest && particle.sightings.size() <= kPlacesPerSight;
    particle.log_weight += kWeightGain * (best_fit - 0.5) + pull_cost(particle.pose, example.pose, first);
    particle.pose = example.pose;
    keep_newest(particle.sightings);
  }
}

double PathFilter::expected_drift_m() const {
  const double way = frames_.back().travelled_m - committed_at_m_;
  return 0.05 + kDriftPerM * way;
}

/// How far the newest key frame may be off against a place: neither farther than the path drifted since it
/// was last tied to anything, nor farther than it drifted since the robot was at that place.
double PathFilter::farthest_offset_m(std::size_t place) const {
  const double since_place = frames_.back().travelled_m - frames_[place].travelled_m;
  const double way = std::min(since_place, frames_.back().travelled_m - committed_at_m_);
  return kFarthestPullM + kFarthestDrifts * kDriftPerM * way;
}

/// Looks for the newest key frame in one old place after another, farther than particles reach.
void PathFilter::search_far() {
  const double window = std::min(kWidestWindowM, std::max(kFarWindowM, 2.5 * expected_drift_m()));
  const Pose2 middle = graph_.poses().back();
  const auto places = old_places_near(middle, window + kSightRadiusM, 8);
  if (places.empty()) return;
  const std::size_t frame = places[next_far_++ % places.size()];
  Place& place = places_.at(frame, old_end(), frames_, graph_.poses());
  if (!place.pyramid) place.pyramid = std::make_unique<SearchPyramid>(place.map);
  const Pose2 centre = between(graph_.poses()[frame], middle);
  const double turn = std::min(0.6, 0.15 + 0.03 * expected_drift_m());
  const auto found =
      search_wide(*place.pyramid, frames_.back().points, {centre, window, turn}, kFarScore, kFarNodes);
  if (!found) return;
  const auto seen = look_at(frame, compose(graph_.poses()[frame], found->pose), 0.5, 0.2);
  if (seen && seen->sighting.fit >= kFarFit) inject(*seen);
}

/// A pose from afar takes the place of the least likely particle, with an average weight to begin with.
void PathFilter::inject(const Candidate& candidate) {
  const bool known = std::any_of(particles_.begin(), particles_.end(), [&](const Particle& particle) {
    return near(particle.pose, candidate.pose, kSameClusterM, kSameClusterRad) && !particle.sightings.empty();
  });
  if (known || particles_.size() < 2) {
    if (particles_.size() == 1 && particles_.front().sightings.empty()) {
      particles_.front().pose = candidate.pose;
      particles_.front().sightings.assign(1, candidate.sighting);
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
  *worst = Particle{candidate.pose, mean, {candidate.sighting}, true};
}

}  // namespace extperfc::mapping
