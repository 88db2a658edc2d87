#pragma once

#include <memory>

#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::benchmark {

/// MRPT's CMonteCarloLocalization2D, what its pf-localization runs: likelihood field of the same width, 60
/// beams of 180, its default odometry model and noise. A build without MRPT's library for it has no peer.
class Peer {
 public:
  /// Null where MRPT is missing. `min_particles` < `max_particles`: KLD-sampling.
  [[nodiscard]] static std::unique_ptr<Peer> make(const OccupancyGrid& map, int min_particles,
                                                  int max_particles, std::size_t rays_per_beam);
  virtual ~Peer() = default;
  virtual void begin_at(const Pose2& pose, double sigma_m, double sigma_rad) = 0;
  virtual void initialize_globally() = 0;
  /// One filter step; `motion` since the last one, in the base's frame.
  virtual void update(const LaserScan& scan, const Pose2& motion) = 0;
  [[nodiscard]] virtual Pose2 pose() const = 0;
};

}  // namespace extperfc::benchmark
