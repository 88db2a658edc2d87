#pragma once

#include <cstdint>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/world_spec.hpp"

namespace extperfc::simulate {

/// What a random world may hold. Textures, colours, light, sizes and places are always drawn at random.
struct RandomWorldParams {
  enum class Kind {
    kTable,  ///< a room with objects on a table before the robot, for training images
    kFloor,  ///< rooms along a corridor with doors and furniture, for mapping and navigation
  };
  Kind kind{Kind::kTable};
  int min_objects{3};      ///< of cones, cubes and spheres on the table, [0, 40]
  int max_objects{9};      ///< [min_objects, 40]
  int min_distractors{1};  ///< of bottles, books, cans and the like on the table, [0, 40]
  int max_distractors{7};  ///< [min_distractors, 40]
  double crowded{0.6};     ///< fraction of objects that are put close to another one, [0, 1]
  double stacked{0.12};    ///< fraction of objects that are put on top of another one, [0, 1]
  double person{0.35};     ///< probability of a person in the room, [0, 1]
};

/// The same parameters and seed give the same world on one build. The robot starts at the origin and looks
/// along x. Loose objects touch nothing but what they stand on, and are in equilibrium; what finds no place
/// on a full table is left out. Errors: a parameter out of its range.
[[nodiscard]] Result<WorldSpec> random_world(const RandomWorldParams& params, std::uint64_t seed);

}  // namespace extperfc::simulate
