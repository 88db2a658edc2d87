#pragma once

#include "simulate/worlds/random_scene.hpp"

namespace extperfc::simulate {

/// Floor and walls of any look along the border of the world's floor plan.
void put_room(RandomScene& scene, double height);

/// A table of any size and look before the robot.
TableTop put_table(RandomScene& scene);

}  // namespace extperfc::simulate
