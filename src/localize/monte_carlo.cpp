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

// Neighbouring beams meet the same wall, and the map's errors are theirs in common: they say less than as
// many independent ones. Measured on Intel, 0.25 to 1 serve equally well.
constexpr double kIndependence = 0.5;
constexpr double kLeastEffective = 0.1;  // share of the particles that must count after a scan
constexpr int kRefineBeams = 240;        // all that a usual scanner has
constexpr std::size_t kFewBeams = 10;    // fewer fit everywhere
constexpr std::size_t kTriesPerParticle = 10;
constexpr double kEnoughEvidence = 5;  // of a rival, in log odds
constexpr double kLeastFresh = 0.1;    // share of particles around rivals

void append(ParticleSet& particles, const ParticleSet& more) {
  particles.x.insert(particles.x.end(), more.x.begin(), more.x.end());
  particles.y.insert(particles.y.end(), more.y.begin(), more.y.end());
  particles.yaw.insert(particles.yaw.end(), more.yaw.begin(), more.yaw.end());
}

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
      place_(std::move(map), params),
      recovery_(params.recovery_alpha_slow, params.recovery_alpha_fast) {
  scatter();
}

void MonteCarlo::set_map(std::shared_ptr<const OccupancyGrid> map) {
  const Pose2 old_origin = place_.map->origin;
  place_ = Place(std::move(map), params_);
  const Pose2 new_T_old = between(place_.map->origin, old_origin);
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    const Pose2 moved = compose(new_T_old, {particles_.x[i], particles_.y[i], particles_.yaw[i]});
    particles_.set(i, static_cast<float>(moved.x), static_cast<float>(moved.y),
                   static_cast<float>(moved.yaw));
  }
  recovery_.reset();
  rivals_.clear();
}

void MonteCarlo::begin_anew() {
  updates_ = 0;
  recovery_.reset();
  rivals_.clear();
}

void MonteCarlo::scatter() {
  particles_ = draw_uniform(place_.free_space, static_cast<std::size_t>(params_.max_particles), rng_);
  searching_ = true;
  unseen_ = true;
  begin_anew();
}

void MonteCarlo::spread(const Pose2& mean, const Eigen::Matrix3d& root) {
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
  begin_anew();
}

void MonteCarlo::move(const Pose2& motion) {
  move_particles(params_, motion, rng_, particles_);
  rivals_.move(motion);
}

PoseEstimate MonteCarlo::weigh(const LaserScan& scan) {
  const Beams beams = select_beams(scan, params_);
  const Beams all_beams = refining_beams(scan, params_);
  if (unseen_ && beams.ends() > 0) {
    particles_ = search_scan(place_, beams, kTriesPerParticle * particles_.size(), particles_.size(), rng_);
    unseen_ = false;
  }
  const std::size_t count = params_.sensor_model == SensorModel::kBeam ? beams.range_m.size() : beams.ends();
  const double sharpness_share = count > 0 ? weigh_particles(beams, count) : 1;
  const PoseBins bins(particles_);
  PoseEstimate estimate = heaviest_cluster(particles_, bins);
  refine_estimate(all_beams, estimate);
  estimate.fit = place_.fit(all_beams, estimate.pose);
  if (all_beams.ends() >= kFewBeams) doubt(beams, all_beams, estimate);
  estimate.resampled = count > 0 && ++updates_ % params_.resample_interval == 0;
  if (estimate.resampled) resample(bins, sharpness_share);
  return estimate;
}

/// Returns how sharp the likelihood could be used, as a share of what it should be.
double MonteCarlo::weigh_particles(const Beams& beams, std::size_t count) {
  if (params_.sensor_model == SensorModel::kBeam)
    beam_model_.mean_logs(place_.field, beams, particles_, logs_);
  else
    place_.exact.mean_logs(place_.field, beams, particles_, logs_);
  const double most = kIndependence * static_cast<double>(count);
  const double sharpness = bearable_sharpness(particles_.weight, logs_, most,
                                              kLeastEffective * static_cast<double>(particles_.size()));
  reweigh(particles_.weight, logs_, sharpness);
  return sharpness / most;
}

/// Matches the scan from the cluster's mean. Its covariance keeps the directions that the scan leaves open.
void MonteCarlo::refine_estimate(const Beams& all_beams, PoseEstimate& estimate) {
  constexpr double kTooWide_m = 0.5;
  constexpr double kLoosening = 4;  // the particles have seen this scan already
  if (searching_ || all_beams.ends() < kFewBeams) return;
  if (estimate.covariance(0, 0) + estimate.covariance(1, 1) > kTooWide_m * kTooWide_m) return;
  const Eigen::Matrix3d least = Eigen::Vector3d(1e-4, 1e-4, 1e-5).asDiagonal();
  const Eigen::Matrix3d prior = (kLoosening * (estimate.covariance + least)).inverse();
  const Pose2 refined =
      refine(place_.field, all_beams, estimate.pose, prior, kRefineSigma_m, place_.rand_per_hit).pose;
  if (place_.mean_log(all_beams, refined) >= place_.mean_log(all_beams, estimate.pose))
    estimate.pose = refined;
}

/// Is the robot where it is thought to be?
void MonteCarlo::doubt(const Beams& beams, const Beams& all_beams, const PoseEstimate& estimate) {
  constexpr double kDecided = 0.95;  // weight of the cluster
  constexpr double kFits = 0.6;
  constexpr double kAsUsual = 0.93;
  const double agreement = place_.agreement(all_beams, estimate.pose);
  if (searching_ && estimate.cluster_weight > kDecided && estimate.fit > kFits) {
    searching_ = false;
    recovery_.reset();
  }
  if (params_.recovery_alpha_slow <= 0) return;
  if (!searching_) recovery_.add(std::exp(agreement));
  if (searching_ || recovery_.share() > 0)
    rivals_.challenge(place_, beams, all_beams, estimate.pose, agreement,
                      std::log(kAsUsual * recovery_.usual()), rng_);
  else
    rivals_.clear();
}

void MonteCarlo::resample(const PoseBins& bins, double sharpness_share) {
  constexpr double kShake_m = 0.01;
  constexpr double kShake_rad = 0.004;
  constexpr double kMostShake_m = 0.1;
  constexpr double kMostShake_rad = 0.05;
  const std::size_t count = kld_count(
      particles_.weight, bins.bin_of(), bins.bins(), static_cast<std::size_t>(params_.min_particles),
      static_cast<std::size_t>(params_.max_particles), params_.kld_err, kld_quantile_, rng_);
  const auto rivals = rivals_.with_evidence(searching_ ? 0 : kEnoughEvidence);
  const double share = rivals.empty() ? 0 : std::max(kLeastFresh, recovery_.share());
  const auto fresh = static_cast<std::size_t>(share * static_cast<double>(count));
  ParticleSet next = pick(particles_, sample_systematic(particles_.weight, count - fresh, rng_));
  // Copies must part again even where odometry adds no noise, the more the farther they lie from the peak.
  const double width = 1 / std::sqrt(sharpness_share);
  shake(next, std::min(kShake_m * width, kMostShake_m), std::min(kShake_rad * width, kMostShake_rad), rng_);
  if (fresh > 0) append(next, spread_around(rivals, fresh, rng_));
  particles_ = std::move(next);
  particles_.make_weights_equal();
}

}  // namespace extperfc::localize
