#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "extperfc/base/rng.hpp"
#include "extperfc/localize/localizer.hpp"

#include "localize/beam_model.hpp"
#include "localize/beams.hpp"
#include "localize/particle_set.hpp"
#include "localize/place.hpp"
#include "localize/pose_bins.hpp"
#include "localize/recovery.hpp"
#include "localize/rivals.hpp"

namespace extperfc::localize {

/// The particle filter. Poses are metres from the map's lower left corner, along the map's own axes.
class MonteCarlo {
 public:
  MonteCarlo(const LocalizerParams& params, std::shared_ptr<const OccupancyGrid> map);

  void set_map(std::shared_ptr<const OccupancyGrid> map);
  [[nodiscard]] const OccupancyGrid& map() const { return *place_.map; }

  void scatter();
  /// Particles normally distributed around `mean`; `root` * its transpose is the covariance.
  void spread(const Pose2& mean, const Eigen::Matrix3d& root);
  void move(const Pose2& motion);
  /// Weighs the particles with a scan, resamples when it is time, and returns the pose.
  [[nodiscard]] PoseEstimate weigh(const LaserScan& scan);

  [[nodiscard]] const ParticleSet& particles() const { return particles_; }

 private:
  void begin_anew();
  double weigh_particles(const Beams& beams, std::size_t count);
  void refine_estimate(const Beams& all_beams, PoseEstimate& estimate);
  void doubt(const Beams& beams, const Beams& all_beams, const PoseEstimate& estimate);
  void resample(const PoseBins& bins, double sharpness_share);

  LocalizerParams params_;
  double kld_quantile_;
  Rng rng_;
  BeamModel beam_model_;
  Place place_;
  Recovery recovery_;
  Rivals rivals_;
  ParticleSet particles_;
  std::vector<float> logs_;  ///< by particle
  int updates_{0};
  bool searching_{false};  ///< after scatter(), until one cluster is left that fits
  bool unseen_{false};     ///< after scatter(), until the first scan
};

}  // namespace extperfc::localize
