#include "mapping/path_filter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "mapping/map_parts.hpp"
#include "mapping/path_filter_common.hpp"
#include "mapping/rotation_by.hpp"

namespace extperfc::mapping {

namespace {

// Wide searches.
constexpr double kFarAfterM = 8.0;    // distance since the last accepted loop closure
constexpr std::size_t kFarEvery = 3;  // key frames

/// Draws from a normal distribution with the inverse of `information` as covariance.
Eigen::Vector3d draw(const Eigen::Matrix3d& covariance, Rng& rng) {
  const Eigen::LLT<Eigen::Matrix3d> root(covariance);
  const Eigen::Vector3d z(rng.normal(0, 1), rng.normal(0, 1), rng.normal(0, 1));
  if (root.info() != Eigen::Success) return Eigen::Vector3d::Zero();
  return root.matrixL() * z;
}

/// Covariance of a tracked step: the tracker's local map averages over many scans, so its frame drifts by a
/// fraction of what one match is uncertain by; and of drift that the match does not observe.
Eigen::Matrix3d step_covariance(const TrackedStep& step) {
  constexpr double kAveraged = 0.15;   // of a match's covariance
  constexpr double kDriftRad2 = 1e-6;  // per key frame
  constexpr double kDriftRad2PerM = 1e-5;
  constexpr double kDriftRadPerRad = 0.004;
  const double sigma_m = 0.003 + kDriftPerM * 0.5 * step.distance_m;
  const double rotation_rad = kDriftRadPerRad * step.step.yaw;
  Eigen::Matrix3d covariance = kAveraged * (step.information + 1e-3 * Eigen::Matrix3d::Identity()).inverse();
  covariance += step.doubt;
  covariance.diagonal() +=
      Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m,
                      kDriftRad2 + kDriftRad2PerM * step.distance_m + rotation_rad * rotation_rad);
  return covariance;
}

}  // namespace

PathFilter::PathFilter(const PathFilterParams& params)
    : params_(params), rng_(params.seed), particles_(static_cast<std::size_t>(params.particles)) {}

void PathFilter::begin(const Pose2& pose, KeyFrame frame) {
  frames_.push_back(std::move(frame));
  graph_.add_node(pose);
  know_again();
  collapse();
}

PathFilter::Step PathFilter::add(const TrackedStep& step, KeyFrame frame) {
  const std::size_t last = frames_.size() - 1;
  graph_.add_node(compose(graph_.poses()[last], step.step));
  graph_.add({last, last + 1, step.step, step_covariance(step).inverse(), false});
  frames_.push_back(std::move(frame));
  parts_.push_back(parts_.back());
  profile_.emplace(frames_.back().points);
  move_particles(step);
  find_loop_closures();
  if (frames_.back().travelled_m - accepted_at_m_ > kFarAfterM && frames_.size() % kFarEvery == 0)
    search_far();
  normalize_weights();
  const auto best = static_cast<std::size_t>(
      std::max_element(particles_.begin(), particles_.end(),
                       [](const auto& a, const auto& b) { return a.log_weight < b.log_weight; }) -
      particles_.begin());
  know_newest();
  if (is_consistent(best)) return accept(best);
  if (effective_ < params_.resample_threshold * static_cast<double>(particles_.size())) resample();
  return {};
}

void PathFilter::add_carried(const std::optional<StartPose>& start, const std::optional<Pose2>& driven,
                             KeyFrame frame) {
  constexpr double kDrivenM = 0.3;
  constexpr double kDrivenRad = 0.2;
  const std::size_t last = frames_.size() - 1;
  if (driven) {
    const Eigen::Vector3d information(1 / (kDrivenM * kDrivenM), 1 / (kDrivenM * kDrivenM),
                                      1 / (kDrivenRad * kDrivenRad));
    driven_.push_back({last, last + 1, *driven, information.asDiagonal().toDenseMatrix(), false});
  }
  const Pose2 pose = start ? start->pose : pose_beside(graph_);
  const auto& poses = graph_.poses();
  graph_.add(unknown_step(last, between(poses[last], pose)));
  if (start) {
    const auto nearest = std::min_element(poses.begin(), poses.end(), [&](const Pose2& a, const Pose2& b) {
      return distance(a, pose) < distance(b, pose);
    });
    const Eigen::Matrix3d rotation = rotation_by(-nearest->yaw);
    const Eigen::Matrix3d covariance = rotation * start->covariance * rotation.transpose();
    graph_.add({static_cast<std::size_t>(nearest - poses.begin()), last + 1, between(*nearest, pose),
                covariance.inverse(), false});
  }
  graph_.add_node(pose);
  frames_.push_back(std::move(frame));
  accepted_at_m_ = frames_.back().travelled_m;
  trusted_constraints_ = graph_.constraints().size();
  know_again();
  collapse();
  if (!start) return;
  for (Particle& particle : particles_) {
    const Eigen::Vector3d noise = draw(start->covariance, rng_);
    particle.pose = {pose.x + noise.x(), pose.y + noise.y(), wrap_angle(pose.yaw + noise.z())};
  }
}

void PathFilter::thin(const std::vector<std::size_t>& frames) {
  for (const std::size_t i : frames) frames_[i].points = ScanPoints{{}, {}, frames_[i].points.scanner};
  if (!frames.empty()) submaps_.clear();
}

std::size_t PathFilter::parts() const {
  return parts_.empty() ? 0 : *std::max_element(parts_.begin(), parts_.end()) + 1;
}

/// What the constraints of the newest key frame tell of it, by the one that tells most.
void PathFilter::know_newest() {
  const std::size_t newest = frames_.size() - 1;
  const auto& constraints = graph_.constraints();
  known_.resize(frames_.size());
  RelativeUncertainty& best = known_.back();
  for (auto constraint = constraints.rbegin(); constraint != constraints.rend(); ++constraint) {
    if (constraint->to != newest) break;
    const auto found = extend(known_[constraint->from], graph_, *constraint);
    if (!best.connected || found.with_bias().trace() < best.with_bias().trace()) best = found;
  }
}

void PathFilter::know_again() {
  known_ = relative_uncertainty(graph_, 0);
  parts_ = parts_of(graph_);
}

void PathFilter::move_particles(const TrackedStep& step) {
  const Eigen::Matrix3d covariance = step_covariance(step);
  for (Particle& particle : particles_) {
    const Eigen::Vector3d noise = draw(covariance, rng_);
    particle.pose =
        compose(particle.pose, {step.step.x + noise.x(), step.step.y + noise.y(), step.step.yaw + noise.z()});
  }
}

void PathFilter::normalize_weights() {
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
  const auto normalized = weights();
  const double step = 1.0 / static_cast<double>(particles_.size());
  std::vector<Particle> drawn;
  drawn.reserve(particles_.size());
  double reached = normalized.front();
  std::size_t i = 0;
  double pointer = rng_.uniform(0, step);
  for (std::size_t k = 0; k < particles_.size(); ++k, pointer += step) {
    while (pointer > reached && i + 1 < particles_.size()) reached += normalized[++i];
    drawn.push_back(particles_[i]);
    drawn.back().log_weight = 0;
  }
  particles_ = std::move(drawn);
}

Eigen::Matrix3d PathFilter::covariance() const {
  const auto normalized = weights();
  const Pose2& centre = particles_.front().pose;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  const auto away = [&](const Particle& particle) {
    return Eigen::Vector3d(particle.pose.x - centre.x, particle.pose.y - centre.y,
                           wrap_angle(particle.pose.yaw - centre.yaw));
  };
  for (std::size_t i = 0; i < normalized.size(); ++i) mean += normalized[i] * away(particles_[i]);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < normalized.size(); ++i) {
    const Eigen::Vector3d d = away(particles_[i]) - mean;
    covariance += normalized[i] * d * d.transpose();
  }
  return covariance;
}

void PathFilter::restore(std::vector<KeyFrame> frames, PoseGraph graph) {
  frames_ = std::move(frames);
  graph_ = std::move(graph);
  know_again();
  accepted_at_m_ = frames_.empty() ? 0 : frames_.back().travelled_m;
  trusted_constraints_ = graph_.constraints().size();
  collapse();
}

}  // namespace extperfc::mapping
