#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "extperfc/base/rng.hpp"
#include "extperfc/localize/localizer.hpp"

#include "localize/beam_model.hpp"
#include "localize/beams.hpp"
#include "localize/map_model.hpp"
#include "localize/particle_set.hpp"
#include "localize/pose_bins.hpp"
#include "localize/pose_hypotheses.hpp"
#include "localize/recovery.hpp"

namespace extperfc::localize {

/// The particle filter. Poses are metres from the map's lower left corner, along the map's own axes.
class MonteCarlo {
 public:
  MonteCarlo(const LocalizerParams& params, std::shared_ptr<const OccupancyGrid> map);

  void set_map(std::shared_ptr<const OccupancyGrid> map);
  [[nodiscard]] const OccupancyGrid& map() const { return *map_model_.map; }

  void initialize_globally();
  /// Particles normally distributed around `mean`; `root` * its transpose is the covariance.
  void initialize_around(const Pose2& mean, const Eigen::Matrix3d& root);
  void propagate(const Pose2& motion);
  /// Reweights the particles by a scan, resamples every resample_interval updates, and returns the pose.
  [[nodiscard]] PoseEstimate update(const LaserScan& scan);

  [[nodiscard]] const ParticleSet& particles() const { return particles_; }

 private:
  void restart();
  double reweight_particles(const Beams& beams, std::size_t count);
  void compare_clusters(const PoseBins& bins, const Beams& all_beams, double likelihood_exponent);
  void refine_estimate(const Beams& all_beams, const PoseBins& bins, PoseEstimate& estimate);
  void test_hypotheses(const Beams& beams, const Beams& all_beams, const PoseEstimate& estimate);
  void resample(const PoseBins& bins, double exponent_fraction);

  LocalizerParams params_;
  double kld_quantile_;
  Rng rng_;
  BeamModel beam_model_;
  MapModel map_model_;
  Recovery recovery_;
  PoseHypotheses hypotheses_;
  ParticleSet particles_;
  std::vector<float> logs_;  ///< by particle
  int updates_{0};
  int tests_left_{0};      ///< updates for which hypotheses are tested
  bool searching_{false};  ///< after initialize_globally(), until one cluster is left that fits
  bool unseen_{false};     ///< after initialize_globally(), until the first scan
};

}  // namespace extperfc::localize
