#pragma once

#include <vector>

#include "extperfc/base/rng.hpp"

#include "localize/beams.hpp"
#include "localize/particle_set.hpp"
#include "localize/place.hpp"

namespace extperfc::localize {

/// A pose that could be the true one instead of the estimate.
struct Rival {
  Pose2 pose;           ///< metres from the map's lower left corner, along its own axes
  double agreement{0};  ///< of the last scan with the map there
  double evidence{0};   ///< log of the odds against the estimate, summed over the scans since it was found
};

/// The other places where the robot could be. While the scans fit badly, every update looks for poses on the
/// whole map that explain the scan, refines the best and compares them with the estimate; each follows
/// odometry and gathers evidence for or against itself. One scan alone moves nobody: it may show people, or a
/// place that only looks alike (a sequential test of odds, Wald 1945).
class Rivals {
 public:
  void clear() { rivals_.clear(); }
  /// The robot moved by `motion` in its own frame.
  void move(const Pose2& motion);
  /// Looks for more and weighs all against `estimate`, where the scan has the agreement `at_estimate`. Those
  /// that agree worse than `usual`, what a robot that knows its place sees, gather evidence more slowly.
  /// O(kTries * 30 + kMost * beams).
  void challenge(const Place& place, const Beams& beams, const Beams& all_beams, const Pose2& estimate,
                 double at_estimate, double usual, Rng& rng);
  /// Those with at least that much evidence, best agreement first.
  [[nodiscard]] std::vector<Rival> with_evidence(double least) const;
  [[nodiscard]] bool empty() const { return rivals_.empty(); }

 private:
  void add_found(const Place& place, const Beams& beams, const Beams& all_beams, const Pose2& estimate,
                 Rng& rng);
  void settle(const Place& place, const Beams& all_beams, Rival& rival) const;

  std::vector<Rival> rivals_;
};

/// `count` particles around the rivals, the better ones with more, with noise. There must be a rival.
[[nodiscard]] ParticleSet spread_around(const std::vector<Rival>& rivals, std::size_t count, Rng& rng);

}  // namespace extperfc::localize
