#pragma once

#include <vector>

#include "simulate/worlds/object_reader.hpp"

namespace extperfc::simulate {

/// What is wrong with objects that are fine on their own: outside the floor plan, inside each other, robot or
/// people where they cannot be. `people` has one origin per person of `world`.
void check_world(const WorldSpec& world, const std::vector<PlacedObject>& objects, const Origin& robot,
                 const std::vector<Origin>& people, Problems& problems);

/// The same of the people from number `first` on, among the bodies of the world.
void check_people(const WorldSpec& world, std::size_t first, const std::vector<Origin>& people,
                  Problems& problems);

/// Depth by which two bodies certainly overlap: of boxes that lie within their shapes [m].
[[nodiscard]] double certain_overlap_m(const BodySpec& a, const BodySpec& b);

}  // namespace extperfc::simulate
