#pragma once

#include "extperfc/base/rng.hpp"
#include "extperfc/simulate/world_spec.hpp"
#include "extperfc/world/shape.hpp"

/// What random objects look like.
namespace extperfc::simulate {

/// From hue, saturation and value, each in [0, 1], to sRGB.
[[nodiscard]] Eigen::Vector3f colour_from_hsv(double hue, double saturation, double value);

/// Any hue, saturation and value from the given ranges.
struct ColourRange {
  double saturation_low, saturation_high;
  double value_low, value_high;
};
[[nodiscard]] Eigen::Vector3f random_colour(Rng& rng, const ColourRange& range);

[[nodiscard]] Material random_paint(Rng& rng);      ///< of toys and tools: vivid, pale, grey or patterned
[[nodiscard]] Material random_wall(Rng& rng);       ///< pale, mostly plaster
[[nodiscard]] Material random_floor(Rng& rng);      ///< wood, tiles, carpet, stone
[[nodiscard]] Material random_table_top(Rng& rng);  ///< wood, plain, cloth, stone, checks
[[nodiscard]] Material random_furniture(Rng& rng);  ///< wood or paint
[[nodiscard]] LightSpec random_light(Rng& rng, const Eigen::Vector2d& room_min_m,
                                     const Eigen::Vector2d& room_max_m, double ceiling_m);

}  // namespace extperfc::simulate
