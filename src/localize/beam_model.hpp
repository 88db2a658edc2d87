#pragma once

#include <vector>

#include "extperfc/localize/localizer.hpp"

#include "localize/beams.hpp"
#include "localize/distance_field.hpp"
#include "localize/particle_set.hpp"

namespace extperfc::localize {

/// Beam model (Probabilistic Robotics, table 6.1): every ray is cast through the map, and the reading is one
/// of a hit near the expected range, a nearer obstacle that the map does not contain, a miss, or random.
class BeamModel {
 public:
  explicit BeamModel(const LocalizerParams& params);

  /// Density of a reading where the map says `expected_m` [1/m]; for a miss (range_m >= max_range_m) its
  /// probability instead. Both together make one, but for the bell's tails beyond the sensor's ranges.
  [[nodiscard]] double likelihood(double range_m, double expected_m, double max_range_m) const;

  /// Mean over the rays of the logarithm of their likelihood relative to a perfect hit's (a miss: to an
  /// expected miss's), within [1e-6, 1], for every particle. O(particles * rays * some ten steps).
  void mean_logs(const DistanceField& field, const Beams& beams, const ParticleSet& particles,
                 std::vector<float>& result) const;

 private:
  double z_hit_;
  double z_short_;
  double z_max_;
  double z_rand_;
  double sigma_m_;
  double lambda_short_;
};

/// Distance from a point to the first obstacle along a direction [m], at most `max_range_m`; `max_range_m`
/// where the ray leaves the map. Exact to about half a cell. The point is in metres from the map's lower left
/// corner.
[[nodiscard]] float cast_ray(const DistanceField& field, float x_m, float y_m, float angle_rad,
                             float max_range_m);

}  // namespace extperfc::localize
