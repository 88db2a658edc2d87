// When particles agree: what they saw becomes part of the pose graph, or is refused.
#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "mapping/path_filter.hpp"
#include "mapping/path_filter_common.hpp"

namespace extperfc::mapping {

namespace {

// Commits.
constexpr double kAgreement = 0.85;     // share of the weight that must agree
constexpr double kSmallOffsetM = 0.15;  // beyond the tracker's own drift: needs no more than one sighting
constexpr std::size_t kNearSightings = 3;
constexpr double kNearWayM = 0.8;
constexpr std::size_t kFarSightings = 8;
constexpr double kFarWayM = 3.0;
constexpr double kBendPerStep = 4.0;  // mean chi-square of tracked steps that a loop may cost
// Relaxing.
constexpr std::size_t kWindow = 60;         // key frames that a small commit moves
constexpr std::size_t kRelaxAllEvery = 60;  // small commits
constexpr double kLargeMoveM = 0.1;
constexpr double kContradictionM = 0.35;  // a correction that casts doubt on what was seen before

}  // namespace

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

}  // namespace extperfc::mapping
