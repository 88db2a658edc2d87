#pragma once

#include <memory>
#include <utility>

#include "extperfc/localize/localizer.hpp"

#include "localize/distance_field.hpp"
#include "localize/field_model.hpp"
#include "localize/free_space.hpp"

namespace extperfc::localize {

/// A map with the fields that are computed from it once. Poses in it are metres from the map's lower left
/// corner, along the map's own axes.
struct MapModel {
  MapModel(std::shared_ptr<const OccupancyGrid> the_map, const LocalizerParams& params);

  std::shared_ptr<const OccupancyGrid> map;
  DistanceField field;
  FreeSpace free_space;
  FieldModel exact;     ///< with the user's sigma
  FieldModel wide;      ///< with twice that, for poses that lie apart from each other
  double rand_per_hit;  ///< z_rand / z_hit

  /// Mean log likelihood of the beams' end points at one pose, in (-inf, 0].
  [[nodiscard]] double mean_log(const Beams& beams, const Pose2& pose) const;
  /// How well a scan agrees with the map at one pose, as the mean of a logarithm per ray, in (-inf, 0].
  /// Unlike mean_log() it considers the whole ray: one that ends before the wall met an object that the map
  /// does not contain, such as a person; one through an obstacle onto another passed where an object was; any
  /// other ray through an obstacle is nearly impossible. `beams` without misses.
  [[nodiscard]] double agreement(const Beams& beams, const Pose2& pose, std::size_t max_rays = 90) const;
  /// Mean of mean_log() and agreement(): for a choice between places. End points alone prefer a wrong place
  /// whose walls the rays pass through where the map has holes; whole rays alone are misled by an object near
  /// the robot that has gone.
  [[nodiscard]] double place_log(const Beams& beams, const Pose2& pose, std::size_t max_rays = 90) const {
    return (mean_log(beams, pose) + agreement(beams, pose, max_rays)) / 2;
  }
  /// Fraction of the beams' end points near an obstacle (0.15 m, or one and a half cells), [0, 1].
  [[nodiscard]] double fit(const Beams& beams, const Pose2& pose) const;
};

}  // namespace extperfc::localize
