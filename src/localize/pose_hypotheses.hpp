#pragma once

#include <vector>

#include "extperfc/base/rng.hpp"

#include "localize/beams.hpp"
#include "localize/map_model.hpp"
#include "localize/particle_set.hpp"

namespace extperfc::localize {

/// A pose that could be the true one instead of the estimate.
struct PoseHypothesis {
  Pose2 pose;           ///< metres from the map's lower left corner, along its own axes
  double agreement{0};  ///< of the last scan with the map there
  double evidence{0};   ///< log of the odds against the estimate, summed over the scans since it was found
};

/// Other pose hypotheses besides the estimate. While the scans fit badly, every update searches the whole map
/// for poses that explain the scan, refines the best and compares them with the estimate. Each hypothesis
/// follows odometry and accumulates evidence for or against itself over several scans (a sequential
/// probability ratio test, Wald 1945), because one scan may show people or a similar place.
class PoseHypotheses {
 public:
  void clear() { hypotheses_.clear(); }
  /// The robot moved by `motion` in its own frame.
  void propagate(const Pose2& motion);
  /// Searches for more hypotheses and tests all against `estimate`, where the scan has the agreement
  /// `at_estimate`. Those that agree worse than `usual`, the average of a localized robot, gain evidence more
  /// slowly. O(kTries * 30 + kMaxHypotheses * beams).
  void test(const MapModel& map_model, const Beams& beams, const Beams& all_beams, const Pose2& estimate,
            double at_estimate, double usual, Rng& rng);
  /// Hypotheses with at least `min_evidence`, best agreement first.
  [[nodiscard]] std::vector<PoseHypothesis> with_evidence(double min_evidence) const;
  [[nodiscard]] bool empty() const { return hypotheses_.empty(); }

 private:
  void add_near(const MapModel& map_model, const Beams& all_beams, const Pose2& estimate, double at_estimate);
  void add_found(const MapModel& map_model, const Beams& beams, const Beams& all_beams, const Pose2& estimate,
                 Rng& rng);
  void refine_pose(const MapModel& map_model, const Beams& all_beams, PoseHypothesis& hypothesis) const;

  std::vector<PoseHypothesis> hypotheses_;
};

/// `count` particles with noise around the hypotheses, more around better ones. Precondition: a hypothesis.
[[nodiscard]] ParticleSet spread_around(const std::vector<PoseHypothesis>& hypotheses, std::size_t count,
                                        Rng& rng);

}  // namespace extperfc::localize
