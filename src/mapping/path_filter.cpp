#include "mapping/path_filter.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace extperfc::mapping {

namespace {

// Places younger than this are the tracker's business.
constexpr double kOldAfterM = 6.0;
constexpr std::size_t kOldAfterFrames = 24;
constexpr double kSightRadiusM = 4.0;  // an old key frame so near sees much the same
constexpr std::size_t kPlacesPerSight = 2;
constexpr std::size_t kOtherPass = 30;  // key frames apart: another pass of the same place
constexpr double kSightSigmaM = 0.3;    // of a particle before it looks
constexpr double kSightSigmaRad = 0.12;
constexpr double kSightReachM = 0.4;
constexpr double kFarthestPullM = 0.6;  // a match that pulls farther found something else
constexpr double kFarthestPullRad = 0.25;
constexpr double kWidestSlideM = 1.2;       // along a corridor
constexpr double kGoodFit = 0.6;            // share of points explained at which a place counts as seen
constexpr double kContradictionCost = 2.0;  // of fit, per share of points and surfaces that cannot be
constexpr double kWeightGain = 6.0;         // log weight per key frame and unit of fit
constexpr double kSameStartM = 0.08;        // particles nearer than this share one match
constexpr double kSameStartRad = 0.02;
// Standard deviations of how far a match may pull a particle: the first one may close the gaps between
// particles.
constexpr double kFirstPullM = 0.2;
constexpr double kPullM = 0.06;
constexpr double kFirstPullRad = 0.08;
constexpr double kPullRad = 0.04;
constexpr double kSameClusterM = 0.3;
constexpr double kSameClusterRad = 0.1;
constexpr std::size_t kMostSightings = 24;  // kept per particle
// Commits.
constexpr double kAgreement = 0.85;     // share of the weight that must agree
constexpr double kSmallOffsetM = 0.15;  // beyond the tracker's own drift: needs no more than one sighting
constexpr std::size_t kNearSightings = 3;
constexpr double kNearWayM = 0.8;
constexpr std::size_t kFarSightings = 8;
constexpr double kFarWayM = 3.0;
constexpr double kDriftPerM = 0.012;     // standard deviation of the tracker's drift
constexpr double kFarthestDrifts = 4.0;  // standard deviations: nothing that far is believed
constexpr double kBendPerStep = 4.0;     // mean chi-square of tracked steps that a loop may cost
// Relaxing.
constexpr std::size_t kWindow = 60;         // key frames that a small commit moves
constexpr std::size_t kRelaxAllEvery = 60;  // small commits
constexpr double kLargeMoveM = 0.1;
constexpr double kContradictionM = 0.35;  // a correction that casts doubt on what was seen before
// Wide searches.
constexpr double kFarAfterM = 8.0;    // way since the last commit
constexpr std::size_t kFarEvery = 3;  // key frames
constexpr double kFarWindowM = 2.0;   // at least
constexpr double kWidestWindowM = 15.0;
constexpr double kFarScore = 0.75;
constexpr int kFarNodes = 20000;
constexpr double kFarFit = 0.65;

/// Draws from a normal distribution with the inverse of `information` as covariance.
Eigen::Vector3d draw(const Eigen::Matrix3d& covariance, Rng& rng) {
  const Eigen::LLT<Eigen::Matrix3d> root(covariance);
  const Eigen::Vector3d z(rng.normal(0, 1), rng.normal(0, 1), rng.normal(0, 1));
  if (root.info() != Eigen::Success) return Eigen::Vector3d::Zero();
  return root.matrixL() * z;
}

/// What a tracked step may be off by: what the match left open, and a drift that no match sees.
Eigen::Matrix3d step_covariance(const TrackedStep& step) {
  const double sigma_m = 0.003 + kDriftPerM * 0.5 * step.way_m;
  const double sigma_rad = 0.0015 + 0.004 * step.way_m + 0.003 * std::abs(step.step.yaw);
  Eigen::Matrix3d covariance = (step.information + 1e-3 * Eigen::Matrix3d::Identity()).inverse();
  covariance.diagonal() += Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad);
  return covariance;
}

double distance(const Pose2& a, const Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

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

double turn_between(const Pose2& a, const Pose2& b) {
  return std::abs(wrap_angle(a.yaw - b.yaw));
}

bool near(const Pose2& a, const Pose2& b, double m, double rad) {
  return distance(a, b) < m && turn_between(a, b) < rad;
}

}  // namespace

/// A match of the newest key frame in an old place.
struct PathFilter::Candidate {
  Pose2 pose;  ///< in the map
  Sighting sighting;
};

PathFilter::PathFilter(const PathFilterParams& params)
    : params_(params), rng_(params.seed), particles_(static_cast<std::size_t>(params.particles)) {}

void PathFilter::begin(const Pose2& pose, KeyFrame frame) {
  frames_.push_back(std::move(frame));
  graph_.add_node(pose);
  collapse();
}

PathFilter::Step PathFilter::add(const TrackedStep& step, KeyFrame frame) {
  const std::size_t last = frames_.size() - 1;
  graph_.add_node(compose(graph_.poses()[last], step.step));
  graph_.add({last, last + 1, step.step, step_covariance(step).inverse(), false});
  frames_.push_back(std::move(frame));
  profile_.emplace(frames_.back().points);
  move_particles(step);
  sight();
  if (frames_.back().travelled_m - committed_at_m_ > kFarAfterM && frames_.size() % kFarEvery == 0)
    search_far();
  weigh();
  const auto best = static_cast<std::size_t>(
      std::max_element(particles_.begin(), particles_.end(),
                       [](const auto& a, const auto& b) { return a.log_weight < b.log_weight; }) -
      particles_.begin());
  if (convincing(best)) return commit(best);
  if (effective_ < params_.resample_threshold * static_cast<double>(particles_.size())) resample();
  return {};
}

void PathFilter::move_particles(const TrackedStep& step) {
  const Eigen::Matrix3d covariance = step_covariance(step);
  for (Particle& particle : particles_) {
    const Eigen::Vector3d noise = draw(covariance, rng_);
    particle.pose =
        compose(particle.pose, {step.step.x + noise.x(), step.step.y + noise.y(), step.step.yaw + noise.z()});
  }
}

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

void PathFilter::weigh() {
  double highest = particles_.front().log_weight;
  for (const Particle& particle : particles_) highest = std::max(highest, particle.log_weight);
  double sum = 0;
  double squares = 0;
  for (Particle& particle : particles_) {
    particle.log_weight -= highest;
    const double weight = std::exp(particle.log_weight);
    sum += weight;
    squares += weight * weight;
  }
  effective_ = sum * sum / squares;
}

std::vector<double> PathFilter::weights() const {
  std::vector<double> weights;
  double sum = 0;
  for (const Particle& particle : particles_) sum += weights.emplace_back(std::exp(particle.log_weight));
  for (double& weight : weights) weight /= sum;
  return weights;
}

double PathFilter::entropy() const {
  double entropy = 0;
  for (const double weight : weights())
    if (weight > 0) entropy -= weight * std::log(weight);
  return entropy;
}

/// Low-variance resampling (Probabilistic Robotics, table 4.4).
void PathFilter::resample() {
  ++resamplings_;
  const auto share = weights();
  const double step = 1.0 / static_cast<double>(particles_.size());
  std::vector<Particle> drawn;
  drawn.reserve(particles_.size());
  double reached = share.front();
  std::size_t i = 0;
  double pointer = rng_.uniform(0, step);
  for (std::size_t k = 0; k < particles_.size(); ++k, pointer += step) {
    while (pointer > reached && i + 1 < particles_.size()) reached += share[++i];
    drawn.push_back(particles_[i]);
    drawn.back().log_weight = 0;
  }
  particles_ = std::move(drawn);
}

/// True when what a particle saw fixes its position in every direction: not so in a bare corridor.
bool PathFilter::determined(const Particle& particle) const {
  constexpr double kSigmaM = 0.08;
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  for (const Sighting& sighting : particle.sightings) {
    const double yaw = graph_.poses()[sighting.relation.from].yaw;
    const Eigen::Rotation2Dd turn(yaw);
    information += turn.toRotationMatrix() * sighting.relation.information.topLeftCorner<2, 2>() *
                   turn.toRotationMatrix().transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(information, Eigen::EigenvaluesOnly);
  return axes.eigenvalues()[0] > 1 / (kSigmaM * kSigmaM);
}

bool PathFilter::convincing(std::size_t best) const {
  const Particle& leader = particles_[best];
  if (leader.sightings.empty() || leader.sightings.back().relation.to != frames_.size() - 1) return false;
  const auto share = weights();
  double agreeing = 0;
  for (std::size_t i = 0; i < particles_.size(); ++i)
    if (near(particles_[i].pose, leader.pose, kSameClusterM, kSameClusterRad)) agreeing += share[i];
  const double offset = distance(leader.pose, graph_.poses().back());
  const double turn = turn_between(leader.pose, graph_.poses().back());
  const double drift = expected_drift_m();
  const auto& first = leader.sightings.front().relation;
  const double way = frames_.back().travelled_m - frames_[first.to].travelled_m;
  if (!leader.injected && offset < kSmallOffsetM + 0.2 * drift && turn < 0.05) return agreeing > 0.5;
  if (agreeing < kAgreement || !determined(leader)) return false;
  if (offset > farthest_offset_m(leader.sightings.back().relation.from)) return false;
  const bool expected = offset < 2 * drift && turn < 0.1 + 0.02 * drift;
  if (expected && !leader.injected) return leader.sightings.size() >= kNearSightings && way >= kNearWayM;
  return leader.sightings.size() >= kFarSightings && way >= kFarWayM;
}

PathFilter::Step PathFilter::commit(std::size_t best) {
  const Particle leader = particles_[best];
  const double moved = distance(leader.pose, graph_.poses().back());
  const auto poses_before = graph_.poses();
  const std::size_t relations_before = graph_.relations().size();
  const auto kept_relations = moved > kContradictionM ? graph_.relations() : std::vector<Relation>{};
  for (const Sighting& sighting : leader.sightings) {
    graph_.add(sighting.relation);
    graph_.relations().back().fit = sighting.fit;
  }
  bool good = relax_commit(moved);
  if (good && moved > kContradictionM) good = review(relations_before);
  if (!good) {
    if (!kept_relations.empty()) graph_.relations() = kept_relations;
    graph_.relations().resize(relations_before);
    graph_.set_poses(poses_before);
    collapse();
    return {};
  }
  if (moved > kLargeMoveM) ++loops_;
  committed_at_m_ = frames_.back().travelled_m;
  collapse();
  return {true, moved > kLargeMoveM};
}

/// Relaxes after a commit. False when the path would have to bend beyond belief.
bool PathFilter::relax_commit(double moved_m) {
  const std::size_t nodes = graph_.poses().size();
  if (moved_m <= kLargeMoveM && ++since_relaxed_ < kRelaxAllEvery)
    return graph_.relax(nodes - std::min(nodes, kWindow), 2);
  since_relaxed_ = 0;
  if (!graph_.relax(0, 8)) return false;
  if (moved_m <= kLargeMoveM) return true;
  double bend = 0;
  std::size_t steps = 0;
  for (const Relation& relation : graph_.relations()) {
    if (relation.sighting || frames_[relation.to].travelled_m < committed_at_m_) continue;
    bend += graph_.squared_error(relation);
    ++steps;
  }
  return bend <= kBendPerStep * static_cast<double>(steps + 10);
}

/// After a commit there is one path; particles spread from its end again.
void PathFilter::collapse() {
  for (Particle& particle : particles_) particle = {graph_.poses().back(), 0.0, {}, false};
  effective_ = static_cast<double>(particles_.size());
}

Eigen::Matrix3d PathFilter::covariance() const {
  const auto share = weights();
  const Pose2& centre = particles_.front().pose;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  const auto away = [&](const Particle& particle) {
    return Eigen::Vector3d(particle.pose.x - centre.x, particle.pose.y - centre.y,
                           wrap_angle(particle.pose.yaw - centre.yaw));
  };
  for (std::size_t i = 0; i < share.size(); ++i) mean += share[i] * away(particles_[i]);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < share.size(); ++i) {
    const Eigen::Vector3d d = away(particles_[i]) - mean;
    covariance += share[i] * d * d.transpose();
  }
  return covariance;
}

/// Matches a sighting anew from where the relaxed path puts it. False when it does not fit there: it has no
/// say then.
bool PathFilter::look_again(Relation& relation) {
  const Pose2 start = between(graph_.poses()[relation.from], graph_.poses()[relation.to]);
  Place& place = places_.at(relation.from, std::min(relation.to, frames_.size()), frames_, graph_.poses());
  const ScanPoints& points = frames_[relation.to].points;
  const auto seen = match(place.map, points, start, {start, kSightSigmaM, kSightSigmaRad}, kSightReachM);
  const double fit =
      seen.fit - kContradictionCost * contradictions(place, points, RangeProfile(points), seen.pose);
  if (fit < kGoodFit || !near(seen.pose, start, kFarthestPullM, kFarthestPullRad)) {
    relation.information.setZero();
    relation.fit = 0;
    return false;
  }
  relation.from_T_to = seen.pose;
  relation.fit = fit;
  return true;
}

/// A correction far beyond the drift since the last commit says that one of the two was wrong. What was seen
/// since the last correction that stood is let go, the path relaxed without it, and all of it matched anew
/// from there. False when the old story explains more than the new one.
bool PathFilter::review(std::size_t relations_before) {
  constexpr std::size_t kMostSuspects = 300;
  std::vector<std::size_t> suspects;
  for (std::size_t i = trusted_relations_; i < relations_before; ++i)
    if (graph_.relations()[i].sighting && graph_.relations()[i].fit > 0) suspects.push_back(i);
  if (suspects.size() > kMostSuspects) suspects.erase(suspects.begin(), suspects.end() - kMostSuspects);
  std::vector<Eigen::Matrix3d> information;
  double old_story = 0;
  for (const std::size_t i : suspects) {
    Relation& relation = graph_.relations()[i];
    old_story += relation.fit;
    information.push_back(relation.information);
    relation.information.setZero();
  }
  if (!graph_.relax(0, 8)) return false;
  double new_story = 0;
  for (std::size_t i = relations_before; i < graph_.relations().size(); ++i)
    new_story += graph_.relations()[i].fit;
  for (std::size_t k = 0; k < suspects.size(); ++k) {
    Relation& relation = graph_.relations()[suspects[k]];
    relation.information = information[k];
    if (look_again(relation)) new_story += relation.fit;
  }
  if (new_story < old_story) return false;
  trusted_relations_ = relations_before;  // this correction may be doubted by the next one
  return graph_.relax(0, 8);
}

/// What most particles agree on and saw well at the end of a recording counts, though a robot that drove on
/// would have had to see more.
void PathFilter::commit_rest() {
  constexpr double kMostAgree = 0.6;
  constexpr std::size_t kFewest = 4;
  if (particles_.empty() || frames_.empty()) return;
  const auto share = weights();
  const auto best = static_cast<std::size_t>(std::max_element(share.begin(), share.end()) - share.begin());
  const Particle& leader = particles_[best];
  if (leader.sightings.size() < kFewest || !determined(leader)) return;
  if (distance(leader.pose, graph_.poses().back()) > farthest_offset_m(leader.sightings.back().relation.from))
    return;
  double agreeing = 0;
  for (std::size_t i = 0; i < particles_.size(); ++i)
    if (near(particles_[i].pose, leader.pose, kSameClusterM, kSameClusterRad)) agreeing += share[i];
  if (agreeing >= kMostAgree) commit(best);
}

void PathFilter::finish() {
  constexpr double kContradicted = 12.0;  // chi-square: one in a hundred
  constexpr int kRounds = 3;
  commit_rest();
  graph_.relax(0, 10);
  for (int round = 0; round < kRounds; ++round) {
    for (Relation& relation : graph_.relations())
      if (relation.sighting && graph_.squared_error(relation) > kContradicted) look_again(relation);
    graph_.relax(0, 6);
  }
  if (!particles_.empty() && !graph_.poses().empty()) collapse();
}

void PathFilter::restore(std::vector<KeyFrame> frames, PoseGraph graph) {
  frames_ = std::move(frames);
  graph_ = std::move(graph);
  committed_at_m_ = frames_.empty() ? 0 : frames_.back().travelled_m;
  trusted_relations_ = graph_.relations().size();
  collapse();
}

}  // namespace extperfc::mapping
