#pragma once

#include <string>

#include "extperfc/simulate/random_world.hpp"

#include "simulate/worlds/random_scene.hpp"

namespace extperfc::simulate {

/// Puts cones, cubes, spheres and other objects on a table top: somewhere, close to each other or on top of
/// each other. None touches another one beside it.
void put_objects(RandomScene& scene, const RandomWorldParams& params, const TableTop& top);

}  // namespace extperfc::simulate
