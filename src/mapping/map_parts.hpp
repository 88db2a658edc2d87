#pragma once

#include <cstddef>
#include <vector>

#include "extperfc/world/pose.hpp"

#include "mapping/pose_graph.hpp"

namespace extperfc::mapping {

// Parts of a map whose poses relative to each other are unknown: before and after a robot was carried, or two
// sessions that are merged. A constraint without knowledge ties a part to the one before it; a loop closure
// between them joins them.

/// A constraint between consecutive key frames that knows nothing: standard deviations of 100 m and half a
/// turn.
[[nodiscard]] Constraint unknown_step(std::size_t from, const Pose2& from_T_to);

/// For every node the number of its part: from 0 on, in the order of their first nodes. Loop closures that
/// the graph contradicts join nothing.
[[nodiscard]] std::vector<std::size_t> parts_of(const PoseGraph& graph);

[[nodiscard]] std::size_t count_parts(const PoseGraph& graph);

/// A pose right of all nodes, for the first node of a new part.
[[nodiscard]] Pose2 pose_beside(const PoseGraph& graph);

/// Moves parts right of those before them, so that they do not overlap.
void set_parts_apart(PoseGraph& graph);

/// Moves the part of `closure.to` as a whole so that it agrees with the closure. Nothing moves within one
/// part.
void bring_together(PoseGraph& graph, const Constraint& closure);

}  // namespace extperfc::mapping
