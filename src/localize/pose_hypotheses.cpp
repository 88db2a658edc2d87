#include "localize/pose_hypotheses.hpp"

#include <algorithm>
#include <cmath>

#include "localize/pose_bins.hpp"
#include "localize/refine.hpp"
#include "localize/scan_search.hpp"
#include "localize/weights.hpp"

namespace extperfc::localize {

namespace {

constexpr std::size_t kTries = 8000;
constexpr std::size_t kFound = 200;         // poses of a search, most of them in a few clusters
constexpr std::size_t kMaxHypotheses = 24;  // hypotheses
constexpr double kSame_m = 0.4;             // nearer poses are the same
constexpr double kSame_rad = 0.3;
constexpr double kAtEstimate_m = 0.12;  // the same as the estimate, which was refined itself
constexpr double kAtEstimate_rad = 0.08;
constexpr double kBetter = 0.05;  // agreement of a pose near the estimate that is worth a test
constexpr double kIndependentBeams = 30;
constexpr double kMaxPerScan = 3;  // of evidence
constexpr double kMaxOfPoor = 1;   // the same for a hypothesis that explains the scan less well than usual
constexpr double kRejected = -3;

bool same_pose(const Pose2& a, const Pose2& b) {
  return is_near(a, b, kSame_m, kSame_rad);
}

/// One pose of each bin, the most crowded bins first.
std::vector<Pose2> distinct(const ParticleSet& poses, std::size_t max_count) {
  const PoseBins bins(poses);
  std::vector<std::size_t> crowd(bins.bins(), 0);
  std::vector<std::size_t> member(bins.bins(), 0);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    ++crowd[bins.bin_of()[i]];
    member[bins.bin_of()[i]] = i;
  }
  std::vector<std::size_t> order(bins.bins());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return crowd[a] > crowd[b]; });
  std::vector<Pose2> picked;
  for (std::size_t i = 0; i < std::min(max_count, order.size()); ++i) {
    const std::size_t p = member[order[i]];
    picked.push_back(poses.pose(p));
  }
  return picked;
}

}  // namespace

void PoseHypotheses::propagate(const Pose2& motion) {
  for (PoseHypothesis& hypothesis : hypotheses_) hypothesis.pose = compose(hypothesis.pose, motion);
}

void PoseHypotheses::refine_pose(const MapModel& map_model, const Beams& all_beams,
                                 PoseHypothesis& hypothesis) const {
  hypothesis.pose = refine(map_model.field, all_beams, hypothesis.pose, loose_prior(), kRefineSigma_m,
                           map_model.rand_per_hit)
                        .pose;
  hypothesis.agreement = map_model.agreement(all_beams, hypothesis.pose);
}

/// Where wheels turn and the robot does not, it stands near the estimate, but farther off than a match
/// reaches.
void PoseHypotheses::add_near(const MapModel& map_model, const Beams& all_beams, const Pose2& estimate,
                              double at_estimate) {
  PoseHypothesis best{estimate, at_estimate + kBetter, 0};
  bool found = false;
  for (const double yaw : {-0.4, -0.2, 0.0, 0.2, 0.4})
    for (const double x : {-0.3, 0.0, 0.3})
      for (const double y : {-0.3, 0.0, 0.3}) {
        PoseHypothesis hypothesis{compose(estimate, {x, y, yaw}), 0, 0};
        refine_pose(map_model, all_beams, hypothesis);
        if (hypothesis.agreement <= best.agreement) continue;
        best = hypothesis;
        found = true;
      }
  const auto known = [&](const PoseHypothesis& other) {
    return is_near(best.pose, other.pose, kAtEstimate_m, kAtEstimate_rad);
  };
  if (!found || is_near(best.pose, estimate, kAtEstimate_m, kAtEstimate_rad) ||
      std::any_of(hypotheses_.begin(), hypotheses_.end(), known))
    return;
  hypotheses_.push_back(best);
}

void PoseHypotheses::add_found(const MapModel& map_model, const Beams& beams, const Beams& all_beams,
                               const Pose2& estimate, Rng& rng) {
  for (const Pose2& pose : distinct(search_scan(map_model, beams, kTries, kFound, rng), kMaxHypotheses)) {
    PoseHypothesis hypothesis{pose, 0, 0};
    refine_pose(map_model, all_beams, hypothesis);
    const bool known = same_pose(hypothesis.pose, estimate) ||
                       std::any_of(hypotheses_.begin(), hypotheses_.end(), [&](const PoseHypothesis& other) {
                         return same_pose(hypothesis.pose, other.pose);
                       });
    if (!known) hypotheses_.push_back(hypothesis);
  }
}

void PoseHypotheses::test(const MapModel& map_model, const Beams& beams, const Beams& all_beams,
                          const Pose2& estimate, double at_estimate, double usual, Rng& rng) {
  for (PoseHypothesis& hypothesis : hypotheses_) refine_pose(map_model, all_beams, hypothesis);
  add_near(map_model, all_beams, estimate, at_estimate);
  add_found(map_model, beams, all_beams, estimate, rng);
  for (PoseHypothesis& hypothesis : hypotheses_) {
    const double max_gain = hypothesis.agreement >= usual ? kMaxPerScan : kMaxOfPoor;
    hypothesis.evidence +=
        std::clamp(kIndependentBeams * (hypothesis.agreement - at_estimate), -kMaxPerScan, max_gain);
  }
  const auto gone =
      std::remove_if(hypotheses_.begin(), hypotheses_.end(), [&](const PoseHypothesis& hypothesis) {
        return hypothesis.evidence <= kRejected ||
               is_near(hypothesis.pose, estimate, kAtEstimate_m, kAtEstimate_rad);
      });
  hypotheses_.erase(gone, hypotheses_.end());
  std::stable_sort(hypotheses_.begin(), hypotheses_.end(),
                   [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.evidence > b.evidence; });
  if (hypotheses_.size() > kMaxHypotheses) hypotheses_.resize(kMaxHypotheses);
}

std::vector<PoseHypothesis> PoseHypotheses::with_evidence(double min_evidence) const {
  std::vector<PoseHypothesis> chosen;
  for (const PoseHypothesis& hypothesis : hypotheses_)
    if (hypothesis.evidence >= min_evidence) chosen.push_back(hypothesis);
  std::stable_sort(chosen.begin(), chosen.end(), [](const PoseHypothesis& a, const PoseHypothesis& b) {
    return a.agreement > b.agreement;
  });
  return chosen;
}

ParticleSet spread_around(const std::vector<PoseHypothesis>& hypotheses, std::size_t count, Rng& rng) {
  constexpr double kSpread_m = 0.05;
  constexpr double kSpread_rad = 0.02;
  ParticleSet centres;
  centres.resize(hypotheses.size());
  centres.make_weights_equal();
  std::vector<float> logs;
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    centres.set(i, static_cast<float>(hypotheses[i].pose.x), static_cast<float>(hypotheses[i].pose.y),
                static_cast<float>(hypotheses[i].pose.yaw));
    logs.push_back(static_cast<float>(hypotheses[i].agreement));
  }
  reweight(centres.weight, logs, kIndependentBeams);
  ParticleSet particles = pick(centres, sample_systematic(centres.weight, count, rng));
  add_jitter(particles, kSpread_m, kSpread_rad, rng);
  return particles;
}

}  // namespace extperfc::localize
