#include "localize/rivals.hpp"

#include <algorithm>
#include <cmath>

#include "localize/pose_bins.hpp"
#include "localize/refine.hpp"
#include "localize/scan_search.hpp"
#include "localize/weights.hpp"

namespace extperfc::localize {

namespace {

constexpr std::size_t kTries = 8000;
constexpr std::size_t kFound = 200;  // poses of a search, most of them in the same few places
constexpr std::size_t kMost = 24;    // rivals
constexpr double kSame_m = 0.4;      // nearer poses are the same place
constexpr double kSame_rad = 0.3;
constexpr double kIndependentBeams = 30;
constexpr double kMostPerScan = 3;  // of evidence
constexpr double kMostOfPoor = 1;   // the same for a rival that explains the scan less well than usual
constexpr double kDefeated = -3;

bool same_place(const Pose2& a, const Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y) < kSame_m && std::abs(wrap_angle(a.yaw - b.yaw)) < kSame_rad;
}

/// One pose of each bin, the most crowded bins first.
std::vector<Pose2> distinct(const ParticleSet& poses, std::size_t most) {
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
  for (std::size_t i = 0; i < std::min(most, order.size()); ++i) {
    const std::size_t p = member[order[i]];
    picked.push_back({poses.x[p], poses.y[p], poses.yaw[p]});
  }
  return picked;
}

}  // namespace

void Rivals::move(const Pose2& motion) {
  for (Rival& rival : rivals_) rival.pose = compose(rival.pose, motion);
}

void Rivals::settle(const Place& place, const Beams& all_beams, Rival& rival) const {
  const Eigen::Matrix3d loose = Eigen::Vector3d(1, 1, 10).asDiagonal();
  rival.pose = refine(place.field, all_beams, rival.pose, loose, kRefineSigma_m, place.rand_per_hit).pose;
  rival.agreement = place.agreement(all_beams, rival.pose);
}

void Rivals::add_found(const Place& place, const Beams& beams, const Beams& all_beams, const Pose2& estimate,
                       Rng& rng) {
  for (const Pose2& pose : distinct(search_scan(place, beams, kTries, kFound, rng), kMost)) {
    Rival rival{pose, 0, 0};
    settle(place, all_beams, rival);
    const bool known = same_place(rival.pose, estimate) ||
                       std::any_of(rivals_.begin(), rivals_.end(),
                                   [&](const Rival& other) { return same_place(rival.pose, other.pose); });
    if (!known) rivals_.push_back(rival);
  }
}

void Rivals::challenge(const Place& place, const Beams& beams, const Beams& all_beams, const Pose2& estimate,
                       double at_estimate, double usual, Rng& rng) {
  for (Rival& rival : rivals_) settle(place, all_beams, rival);
  add_found(place, beams, all_beams, estimate, rng);
  for (Rival& rival : rivals_) {
    const double most = rival.agreement >= usual ? kMostPerScan : kMostOfPoor;
    rival.evidence += std::clamp(kIndependentBeams * (rival.agreement - at_estimate), -kMostPerScan, most);
  }
  const auto gone = std::remove_if(rivals_.begin(), rivals_.end(), [&](const Rival& rival) {
    return rival.evidence <= kDefeated || same_place(rival.pose, estimate);
  });
  rivals_.erase(gone, rivals_.end());
  std::stable_sort(rivals_.begin(), rivals_.end(),
                   [](const Rival& a, const Rival& b) { return a.evidence > b.evidence; });
  if (rivals_.size() > kMost) rivals_.resize(kMost);
}

std::vector<Rival> Rivals::with_evidence(double least) const {
  std::vector<Rival> chosen;
  for (const Rival& rival : rivals_)
    if (rival.evidence >= least) chosen.push_back(rival);
  std::stable_sort(chosen.begin(), chosen.end(),
                   [](const Rival& a, const Rival& b) { return a.agreement > b.agreement; });
  return chosen;
}

ParticleSet spread_around(const std::vector<Rival>& rivals, std::size_t count, Rng& rng) {
  constexpr double kSpread_m = 0.05;
  constexpr double kSpread_rad = 0.02;
  ParticleSet centres;
  centres.resize(rivals.size());
  centres.make_weights_equal();
  std::vector<float> logs;
  for (std::size_t i = 0; i < rivals.size(); ++i) {
    centres.set(i, static_cast<float>(rivals[i].pose.x), static_cast<float>(rivals[i].pose.y),
                static_cast<float>(rivals[i].pose.yaw));
    logs.push_back(static_cast<float>(rivals[i].agreement));
  }
  reweigh(centres.weight, logs, kIndependentBeams);
  ParticleSet particles = pick(centres, sample_systematic(centres.weight, count, rng));
  shake(particles, kSpread_m, kSpread_rad, rng);
  return particles;
}

}  // namespace extperfc::localize
