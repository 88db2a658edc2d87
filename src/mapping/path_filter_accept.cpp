// Accepts or rejects the loop-closure candidates on which the particles agree.
#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "mapping/closed_graph.hpp"
#include "mapping/path_filter.hpp"
#include "mapping/path_filter_common.hpp"

namespace extperfc::mapping {

namespace {

// Acceptance.
constexpr double kAgreement = 0.85;     // fraction of the weight that must agree
constexpr double kSmallOffsetM = 0.15;  // beyond the tracker's own drift: needs no more than one candidate
constexpr std::size_t kMinNearCandidates = 3;
constexpr double kMinNearDistanceM = 0.8;
constexpr std::size_t kMinFarCandidates = 8;
constexpr double kMinFarDistanceM = 3.0;
constexpr double kMaxSquaredErrorPerStep = 4.0;  // mean chi-square of tracked steps that a loop may cost
// Optimization.
constexpr std::size_t kWindow = 60;            // key frames that a small correction moves
constexpr std::size_t kOptimizeAllEvery = 60;  // small corrections
constexpr double kLargeMoveM = 0.1;
constexpr double kBetweenLoopsM = 5.0;    // without a closure, until the next one counts as another loop
constexpr double kContradictionM = 0.35;  // a larger correction contradicts earlier loop closures

}  // namespace

/// True when a particle's candidates constrain its position in every direction: false in a bare corridor.
bool PathFilter::determined(const Particle& particle) const {
  constexpr double kSigmaM = 0.08;
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  for (const LoopClosureCandidate& candidate : particle.candidates) {
    const double yaw = graph_.poses()[candidate.constraint.from].yaw;
    const Eigen::Rotation2Dd rotation(yaw);
    information += rotation.toRotationMatrix() * candidate.constraint.information.topLeftCorner<2, 2>() *
                   rotation.toRotationMatrix().transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(information, Eigen::EigenvaluesOnly);
  return axes.eigenvalues()[0] > 1 / (kSigmaM * kSigmaM);
}

bool PathFilter::is_consistent(std::size_t best) const {
  const Particle& leader = particles_[best];
  if (leader.candidates.empty() || leader.candidates.back().constraint.to != frames_.size() - 1) return false;
  const auto normalized = weights();
  double agreeing = 0;
  for (std::size_t i = 0; i < particles_.size(); ++i)
    if (near(particles_[i].pose, leader.pose, kSameClusterM, kSameClusterRad)) agreeing += normalized[i];
  const double offset = distance(leader.pose, graph_.poses().back());
  const double yaw_offset = yaw_between(leader.pose, graph_.poses().back());
  const double drift = expected_drift_m();
  const auto& first = leader.candidates.front().constraint;
  const double travelled_m = frames_.back().travelled_m - frames_[first.to].travelled_m;
  if (!leader.injected && offset < kSmallOffsetM + 0.2 * drift && yaw_offset < 0.05) return agreeing > 0.5;
  if (agreeing < kAgreement || !determined(leader)) return false;
  if (offset > farthest_offset_m(leader.candidates.back().constraint.from)) return false;
  const bool expected = offset < 2 * drift && yaw_offset < 0.1 + 0.02 * drift;
  if (expected && !leader.injected)
    return leader.candidates.size() >= kMinNearCandidates && travelled_m >= kMinNearDistanceM;
  return leader.candidates.size() >= kMinFarCandidates && travelled_m >= kMinFarDistanceM;
}

/// Whether much the same correction was refused within the last metres. To review it again would take as
/// long, and say the same.
bool PathFilter::was_refused(const Pose2& correction) const {
  constexpr double kReviewedAgainAfterM = 3.0;
  return refused_ && frames_.back().travelled_m - refused_->at_m < kReviewedAgainAfterM &&
         near(correction, refused_->correction, kSameClusterM, kSameClusterRad);
}

PathFilter::Step PathFilter::accept(std::size_t best) {
  const Particle leader = particles_[best];
  const Pose2 correction = between(graph_.poses().back(), leader.pose);
  const double moved = std::hypot(correction.x, correction.y);
  if (moved > kContradictionM && was_refused(correction)) {
    collapse();
    return {};
  }
  const auto poses_before = graph_.poses();
  const std::size_t constraints_before = graph_.constraints().size();
  const auto kept_constraints = moved > kContradictionM ? graph_.constraints() : std::vector<Constraint>{};
  for (const LoopClosureCandidate& candidate : leader.candidates) {
    graph_.add(candidate.constraint);
    graph_.constraints().back().fit = candidate.fit;
  }
  bool good = optimize_accepted(moved);
  if (good && moved > kContradictionM) good = review(constraints_before);
  if (!good) {
    if (!kept_constraints.empty()) graph_.constraints() = kept_constraints;
    graph_.constraints().resize(constraints_before);
    graph_.set_poses(poses_before);
    if (moved > kContradictionM) refused_ = {correction, frames_.back().travelled_m};
    collapse();
    return {};
  }
  if (moved > kLargeMoveM || frames_.back().travelled_m - accepted_at_m_ > kBetweenLoopsM) ++loops_;
  accepted_at_m_ = frames_.back().travelled_m;
  if (moved > kLargeMoveM)
    know_again();
  else
    know_newest();
  collapse();
  return {true, moved > kLargeMoveM};
}

/// Optimizes with the new constraints. False when the tracked steps contradict the result.
bool PathFilter::optimize_accepted(double moved_m) {
  const std::size_t nodes = graph_.poses().size();
  if (moved_m <= kLargeMoveM && ++since_optimized_ < kOptimizeAllEvery)
    return graph_.optimize(nodes - std::min(nodes, kWindow), 2);
  since_optimized_ = 0;
  if (!graph_.optimize(0, 8)) return false;
  if (moved_m <= kLargeMoveM) return true;
  double squared_error = 0;
  std::size_t steps = 0;
  for (const Constraint& constraint : graph_.constraints()) {
    if (constraint.is_loop_closure || frames_[constraint.to].travelled_m < accepted_at_m_) continue;
    squared_error += graph_.squared_error(constraint);
    ++steps;
  }
  return squared_error <= kMaxSquaredErrorPerStep * static_cast<double>(steps + 10);
}

/// After an accepted loop closure there is one path; the particles start at its end again.
void PathFilter::collapse() {
  for (Particle& particle : particles_) particle = {graph_.poses().back(), 0.0, {}, false};
  effective_ = static_cast<double>(particles_.size());
}

/// Matches a loop closure again from the optimized pose. False when it does not fit there: its weight is then
/// zero. That of a thinned key frame stays as it is.
bool PathFilter::rematch(Constraint& constraint) {
  if (frames_[constraint.to].is_thinned()) return true;
  const Pose2 start = between(graph_.poses()[constraint.from], graph_.poses()[constraint.to]);
  Submap& submap =
      submaps_.at(constraint.from, std::min(constraint.to, frames_.size()), frames_, graph_.poses());
  const ScanPoints& points = frames_[constraint.to].points;
  const auto seen = match(submap.map, points, start, {start, kMatchSigmaM, kMatchSigmaRad}, kMatchReachM);
  const double fit =
      seen.fit - kContradictionCost * contradictions(submap, points, RangeProfile(points), seen.pose);
  if (fit < kGoodFit || !near(seen.pose, start, kFarthestPullM, kFarthestPullRad)) {
    constraint.information.setZero();
    constraint.fit = 0;
    return false;
  }
  constraint.from_T_to = seen.pose;
  constraint.fit = fit;
  return true;
}

/// What these loop closures, which now fit `present_fit` in total, would fit if each were matched again: from
/// every n-th of them.
double PathFilter::estimated_fit(const std::vector<std::size_t>& closures, double present_fit) {
  constexpr std::size_t kSamples = 40;
  const std::size_t step = 1 + closures.size() / kSamples;
  double before = 0;
  double again = 0;
  for (std::size_t k = 0; k < closures.size(); k += step) {
    Constraint constraint = graph_.constraints()[closures[k]];
    before += constraint.fit;
    if (rematch(constraint)) again += constraint.fit;
  }
  return before > 0 ? present_fit * again / before : 0;
}

/// A correction far beyond the drift since the last accepted loop closure means that one of the two was
/// wrong. Takes out the loop closures since the last trusted correction, optimizes without them, and matches
/// them again from there. False when the old constraints fit better in total than the new ones.
bool PathFilter::review(std::size_t constraints_before) {
  constexpr std::size_t kMaxSuspects = 300;
  constexpr double kClearlyWorse = 0.8;  // an estimate is enough then
  std::vector<std::size_t> suspects;
  for (std::size_t i = trusted_constraints_; i < constraints_before; ++i)
    if (graph_.constraints()[i].is_loop_closure && graph_.constraints()[i].fit > 0) suspects.push_back(i);
  if (suspects.size() > kMaxSuspects) suspects.erase(suspects.begin(), suspects.end() - kMaxSuspects);
  std::vector<Eigen::Matrix3d> information;
  double old_fit = 0;
  for (const std::size_t i : suspects) {
    Constraint& constraint = graph_.constraints()[i];
    old_fit += constraint.fit;
    information.push_back(constraint.information);
    constraint.information.setZero();
  }
  if (!graph_.optimize(0, 8)) return false;
  double new_fit = 0;
  for (std::size_t i = constraints_before; i < graph_.constraints().size(); ++i)
    new_fit += graph_.constraints()[i].fit;
  if (new_fit + estimated_fit(suspects, old_fit) < kClearlyWorse * old_fit) return false;
  for (std::size_t k = 0; k < suspects.size(); ++k) {
    Constraint& constraint = graph_.constraints()[suspects[k]];
    constraint.information = information[k];
    if (rematch(constraint)) new_fit += constraint.fit;
  }
  if (new_fit < old_fit) return false;
  trusted_constraints_ = constraints_before;  // the next correction may review this one
  return graph_.optimize(0, 8);
}

/// At the end of a recording fewer candidates and less agreement suffice, as no more scans follow.
void PathFilter::accept_rest() {
  constexpr double kMinAgreement = 0.6;
  constexpr std::size_t kMinCandidates = 4;
  if (particles_.empty() || frames_.empty()) return;
  const auto normalized = weights();
  const auto best =
      static_cast<std::size_t>(std::max_element(normalized.begin(), normalized.end()) - normalized.begin());
  const Particle& leader = particles_[best];
  if (leader.candidates.size() < kMinCandidates || !determined(leader)) return;
  if (distance(leader.pose, graph_.poses().back()) >
      farthest_offset_m(leader.candidates.back().constraint.from))
    return;
  double agreeing = 0;
  for (std::size_t i = 0; i < particles_.size(); ++i)
    if (near(particles_[i].pose, leader.pose, kSameClusterM, kSameClusterRad)) agreeing += normalized[i];
  if (agreeing >= kMinAgreement) accept(best);
}

void PathFilter::finish() {
  accept_rest();
  if (frames_.empty()) return;
  graph_ = closed_graph(frames_, std::move(graph_), driven_, submaps_);
  know_closed();
}

PathFilter::Search PathFilter::search() const {
  return {frames_, graph_, driven_};
}

void PathFilter::Search::run() {
  SubmapCache submaps;
  if (!frames.empty()) graph = closed_graph(frames, std::move(graph), driven, submaps);
}

bool PathFilter::adopt(Search search) {
  const std::size_t known = search.frames.size();
  if (known == 0 || known > frames_.size()) return false;
  const auto is_same = [](const KeyFrame& a, const KeyFrame& b) {
    return a.scan == b.scan && a.travelled_m == b.travelled_m;
  };
  if (!is_same(search.frames.front(), frames_.front()) || !is_same(search.frames.back(), frames_[known - 1]))
    return false;
  const auto& poses = graph_.poses();
  const Pose2 moved = compose(search.graph.poses().back(), inverse(poses[known - 1]));
  for (std::size_t i = known; i < poses.size(); ++i) search.graph.add_node(compose(moved, poses[i]));
  for (const Constraint& constraint : graph_.constraints())
    if (constraint.to >= known) search.graph.add(constraint);
  graph_ = std::move(search.graph);
  if (frames_.size() > known) graph_.optimize(0, kGraphIterations);
  know_closed();
  return true;
}

/// After loops of the whole path were closed.
void PathFilter::know_closed() {
  trusted_constraints_ = graph_.constraints().size();
  since_optimized_ = 0;
  refused_.reset();
  know_again();
  collapse();
}

}  // namespace extperfc::mapping
