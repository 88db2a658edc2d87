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
  /// Unlike mean_log() it considers the whole ray: a ray through a wall is nearly impossible, one that ends
  /// before the wall met an object that the map does not contain, such as a person. `beams` without misses;
  /// takes up to 90 rays.
  [[nodiscard]] double agreement(const Beams& beams, const Pose2& pose) const;
  /// Fraction of the beams' end points near an obstacle (0.15 m, or one and a half cells), [0, 1].
  [[nodiscard]] double fit(const Beams& beams, const Pose2& pose) const;
};

}  // namespace extperfc::localize
