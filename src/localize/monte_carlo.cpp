#include "localize/monte_carlo.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "localize/kld.hpp"
#include "localize/odometry.hpp"
#include "localize/refine.hpp"
#include "localize/scan_search.hpp"
#include "localize/weights.hpp"

namespace extperfc::localize {

namespace {

// Neighbouring beams meet the same wall and share the map's errors, so they carry less information than
// independent ones. Measured on Intel, 0.25 to 1 serve equally well.
constexpr double kIndependence = 0.5;
constexpr double kMinEffective = 0.1;  // fraction of the particles that must stay effective after a scan
constexpr int kRefineBeams = 240;      // all that a usual scanner has
constexpr std::size_t kFewBeams = 10;  // fewer fit everywhere
constexpr std::size_t kTriesPerParticle = 10;
constexpr double kEnoughEvidence = 5;  // of a hypothesis, in log odds
constexpr double kMinFresh = 0.1;      // fraction of particles around hypotheses

/// The rays against which single poses are refined and judged: more than the particles can afford.
Beams refining_beams(const LaserScan& scan, LocalizerParams params) {
  params.sensor_model = SensorModel::kLikelihoodField;
  params.laser_max_beams = std::max(params.laser_max_beams, kRefineBeams);
  return select_beams(scan, params);
}

}  // namespace

MonteCarlo::MonteCarlo(const LocalizerParams& params, std::shared_ptr<const OccupancyGrid> map)
    : params_(params),
      kld_quantile_(normal_quantile(params.kld_z)),
      rng_(params.seed),
      beam_model_(params),
      map_model_(std::move(map), params),
      recovery_(params.recovery_alpha_slow, params.recovery_alpha_fast) {
  initialize_globally();
}

void MonteCarlo::set_map(std::shared_ptr<const OccupancyGrid> map) {
  const Pose2 old_origin = map_model_.map->origin;
  map_model_ = MapModel(std::move(map), params_);
  const Pose2 new_T_old = between(map_model_.map->origin, old_origin);
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    const Pose2 moved = compose(new_T_old, {particles_.x[i], particles_.y[i], particles_.yaw[i]});
    particles_.set(i, static_cast<float>(moved.x), static_cast<float>(moved.y),
                   static_cast<float>(moved.yaw));
  }
  recovery_.reset();
  hypotheses_.clear();
}

void MonteCarlo::restart() {
  updates_ = 0;
  recovery_.reset();
  hypotheses_.clear();
  tests_left_ = 0;
}

void MonteCarlo::initialize_globally() {
  particles_ = draw_uniform(map_model_.free_space, static_cast<std::size_t>(params_.max_particles), rng_);
  searching_ = true;
  unseen_ = true;
  restart();
}

void MonteCarlo::initialize_around(const Pose2& mean, const Eigen::Matrix3d& root) {
  particles_.resize(static_cast<std::size_t>(params_.max_particles));
  particles_.make_weights_equal();
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    const Eigen::Vector3d off =
        root * Eigen::Vector3d(rng_.normal(0, 1), rng_.normal(0, 1), rng_.normal(0, 1));
    particles_.set(i, static_cast<float>(mean.x + off.x()), static_cast<float>(mean.y + off.y()),
                   static_cast<float>(wrap_angle(mean.yaw + off.z())));
  }
  searching_ = false;
  unseen_ = false;
  restart();
}

void MonteCarlo::propagate(const Pose2& motion) {
  move_particles(params_, motion, rng_, particles_);
  hypotheses_.propagate(motion);
}

PoseEstimate MonteCarlo::update(const LaserScan& scan) {
  const Beams beams = select_beams(scan, params_);
  const Beams all_beams = refining_beams(scan, params_);
  if (unseen_ && beams.ends() > 0) {
    particles_ =
        search_scan(map_model_, beams, kTriesPerParticle * particles_.size(), particles_.size(), rng_);
    unseen_ = false;
  }
  const std::size_t count = params_.sensor_model == SensorModel::kBeam ? beams.range_m.size() : beams.ends();
  const double exponent_fraction = count > 0 ? reweight_particles(beams, count) : 1;
  const PoseBins bins(particles_);
  if (params_.sensor_model == SensorModel::kLikelihoodField && all_beams.ends() >= kFewBeams)
    compare_clusters(bins, all_beams, exponent_fraction * kIndependence * static_cast<double>(count));
  PoseEstimate estimate = heaviest_cluster(particles_, bins);
  refine_estimate(all_beams, bins, estimate);
  estimate.fit = map_model_.fit(all_beams, estimate.pose);
  if (all_beams.ends() >= kFewBeams) test_hypotheses(beams, all_beams, estimate);
  estimate.resampled = count > 0 && ++updates_ % params_.resample_interval == 0;
  if (estimate.resampled) resample(bins, exponent_fraction);
  return estimate;
}

/// Returns the likelihood exponent used, as a fraction of the exponent without tempering.
double MonteCarlo::reweight_particles(const Beams& beams, std::size_t count) {
  if (params_.sensor_model == SensorModel::kBeam)
    beam_model_.mean_logs(map_model_.field, beams, particles_, logs_);
  else
    map_model_.exact.mean_logs(map_model_.field, beams, particles_, logs_);
  const double max_exponent = kIndependence * static_cast<double>(count);
  const double likelihood_exponent = tempered_exponent(
      particles_.weight, logs_, max_exponent, kMinEffective * static_cast<double>(particles_.size()));
  reweight(particles_.weight, logs_, likelihood_exponent);
  return likelihood_exponent / max_exponent;
}

/// Between places whole rays count too, of which a likelihood field sees the end points alone.
void MonteCarlo::compare_clusters(const PoseBins& bins, const Beams& all_beams, double likelihood_exponent) {
  constexpr std::size_t kMaxClusters = 16;
  constexpr std::size_t kMinParticles = 5;
  const auto cluster_of_bin = bins.clusters();
  auto clusters = list_clusters(particles_, bins, cluster_of_bin, logs_);
  const auto few = [](const Cluster& cluster) { return cluster.particles < kMinParticles; };
  clusters.erase(std::remove_if(clusters.begin(), clusters.end(), few), clusters.end());
  if (clusters.size() < 2) return;
  clusters.resize(std::min(clusters.size(), kMaxClusters));
  std::vector<float> correction(cluster_of_bin.size(), 0.0F);  // by number of cluster
  for (const Cluster& cluster : clusters) {
    const Pose2 pose = refine(map_model_.field, all_beams, particles_.pose(cluster.best), loose_prior(),
                              kRefineSigma_m, map_model_.rand_per_hit)
                           .pose;
    correction[cluster.number] =
        static_cast<float>(map_model_.place_log(all_beams, pose) - map_model_.mean_log(all_beams, pose));
  }
  std::vector<float> corrections(particles_.size());
  for (std::size_t i = 0; i < particles_.size(); ++i)
    corrections[i] = correction[cluster_of_bin[bins.bin_of()[i]]];
  reweight(particles_.weight, corrections, likelihood_exponent);
}

/// Matches the scan from the cluster's mean, and from its best particle where the mean lies off the peak.
/// The cluster's covariance keeps the directions that the scan leaves open.
void MonteCarlo::refine_estimate(const Beams& all_beams, const PoseBins& bins, PoseEstimate& estimate) {
  constexpr double kTooWide_m = 0.5;
  constexpr double kLoosening = 4;  // the particles have seen this scan already
  constexpr double kSame_m = 0.1;
  constexpr double kSame_rad = 0.05;
  if (searching_ || all_beams.ends() < kFewBeams) return;
  if (estimate.covariance(0, 0) + estimate.covariance(1, 1) > kTooWide_m * kTooWide_m) return;
  const Eigen::Matrix3d floor = Eigen::Vector3d(1e-4, 1e-4, 1e-5).asDiagonal();
  const Eigen::Matrix3d prior = (kLoosening * (estimate.covariance + floor)).inverse();
  const auto refined_from = [&](const Pose2& start) {
    return refine(map_model_.field, all_beams, start, prior, kRefineSigma_m, map_model_.rand_per_hit).pose;
  };
  const Pose2 refined = refined_from(estimate.pose);
  const std::size_t best = list_clusters(particles_, bins, bins.clusters(), logs_).front().best;
  const Pose2 other = refined_from(particles_.pose(best));
  if (map_model_.mean_log(all_beams, refined) >= map_model_.mean_log(all_beams, estimate.pose))
    estimate.pose = refined;
  if (!is_near(other, estimate.pose, kSame_m, kSame_rad) &&
      map_model_.place_log(all_beams, other) > map_model_.place_log(all_beams, estimate.pose))
    estimate.pose = other;
}

/// Tests the estimate against other pose hypotheses while the scans fit badly, and a while longer.
void MonteCarlo::test_hypotheses(const Beams& beams, const Beams& all_beams, const PoseEstimate& estimate) {
  constexpr double kDecided = 0.95;  // weight of the cluster
  constexpr double kFits = 0.6;
  constexpr double kAsUsual = 0.93;
  constexpr int kTestsAfter = 20;  // scans fit as usual again: perhaps at a place that looks alike
  const double agreement = map_model_.agreement(all_beams, estimate.pose);
  if (searching_ && estimate.cluster_weight > kDecided && estimate.fit > kFits) {
    searching_ = false;
    recovery_.reset();
  }
  if (params_.recovery_alpha_slow <= 0) return;
  if (!searching_) recovery_.add(std::exp(agreement));
  if (searching_ || recovery_.fraction() > 0)
    tests_left_ = kTestsAfter;
  else if (tests_left_ > 0)
    --tests_left_;
  if (tests_left_ > 0)
    hypotheses_.test(map_model_, beams, all_beams, estimate.pose, agreement,
                     std::log(kAsUsual * recovery_.usual()), rng_);
  else
    hypotheses_.clear();
}

void MonteCarlo::resample(const PoseBins& bins, double exponent_fraction) {
  constexpr double kJitter_m = 0.01;
  constexpr double kJitter_rad = 0.004;
  constexpr double kMaxJitter_m = 0.1;
  constexpr double kMaxJitter_rad = 0.05;
  const std::size_t count = kld_count(
      particles_.weight, bins.bin_of(), bins.bins(), static_cast<std::size_t>(params_.min_particles),
      static_cast<std::size_t>(params_.max_particles), params_.kld_err, kld_quantile_, rng_);
  const auto hypotheses = hypotheses_.with_evidence(searching_ ? 0 : kEnoughEvidence);
  const double fraction = hypotheses.empty() ? 0 : std::max(kMinFresh, recovery_.fraction());
  const auto fresh = static_cast<std::size_t>(fraction * static_cast<double>(count));
  ParticleSet next = pick(particles_, sample_systematic(particles_.weight, count - fresh, rng_));
  // Jitter separates copies even where odometry adds no noise, more the farther they lie from the peak.
  const double width = 1 / std::sqrt(exponent_fraction);
  add_jitter(next, std::min(kJitter_m * width, kMaxJitter_m), std::min(kJitter_rad * width, kMaxJitter_rad),
             rng_);
  if (fresh > 0) append(next, spread_around(hypotheses, fresh, rng_));
  particles_ = std::move(next);
  particles_.make_weights_equal();
}

}  // namespace extperfc::localize
