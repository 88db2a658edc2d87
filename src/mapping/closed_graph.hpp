#pragma once

#include <vector>

#include "mapping/key_frame.hpp"
#include "mapping/pose_graph.hpp"
#include "mapping/submap_cache.hpp"

namespace extperfc::mapping {

/// The graph with the loops of the whole path closed. Two candidates compete: one from the tracked steps
/// alone, and `graph`, with loops closed where it has none; the second has to be clearly more likely, since
/// its closures were accepted before the whole path was known. Passes of known surroundings that contradict
/// each other, and segments that fit badly, are then closed anew, as far as that makes the whole more likely.
/// `frames` must not be empty. Seconds for hundreds of metres.
///
/// `driven` has what odometry measured of unknown steps. Where parts are not joined otherwise, it is tried,
/// in case that the robot was not carried at all; it counts when the parts then fit each other where they
/// meet.
[[nodiscard]] PoseGraph closed_graph(const std::vector<KeyFrame>& frames, PoseGraph graph,
                                     const std::vector<Constraint>& driven, SubmapCache& submaps);

}  // namespace extperfc::mapping
