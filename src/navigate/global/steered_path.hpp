#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// Whether a footprint may move straight from a pose to another one, the yaw turning evenly.
using MotionCheck = std::function<bool(const Pose2& from, const Pose2& to)>;

/// How a differential base passes a narrow place: from `first` straight to the line through `middle` along
/// its yaw, along that line, straight on to `last`; it rotates in place between. Of several such motions the
/// one with the least length, 0.3 m being added for every radian, and 1 m where it does not pass with room.
/// @param passes of all but the line's motion
/// @param passes_with_room of the same: a base that turns in a door's mouth is easily beside the line in the
/// door
/// @param passes_narrow of the motion along the line
/// Empty: no such motion passes.
[[nodiscard]] std::optional<std::vector<Pose2>> straight_passage(const Pose2& first, const Pose2& middle,
                                                                 const Pose2& last, const MotionCheck& passes,
                                                                 const MotionCheck& passes_with_room,
                                                                 const MotionCheck& passes_narrow);

/// A differential base's path without rotations in place where a curve of at most 2.5 1/m passes: at corners,
/// at the start and at the goal. Rotations by more than 2.2 rad, and those between which it drives backwards,
/// stay.
[[nodiscard]] std::vector<Pose2> round_corners(const std::vector<Pose2>& poses, const MotionCheck& passes);

}  // namespace extperfc::navigate
