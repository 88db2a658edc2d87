#pragma once

#include <Eigen/Core>

#include "extperfc/world/pose.hpp"

namespace extperfc::scan {

/// Roll and pitch of a body without its heading: `R = R_z(heading) * tilt_of(R)`. The heading is that of the
/// body's x axis seen from above (yaw of roll, pitch, yaw about fixed axes); a body whose x axis points
/// straight up or down has none, and keeps its whole rotation. `world_R_body` has its z axis along gravity,
/// upwards.
[[nodiscard]] Eigen::Matrix3d tilt_of(const Eigen::Matrix3d& world_R_body);

/// The same place and heading, upright: roll and pitch are zero.
[[nodiscard]] Pose upright(const Pose& world_T_body);

/// The same place and heading with another body's roll and pitch.
[[nodiscard]] Pose with_tilt(const Pose& world_T_body, const Eigen::Matrix3d& world_R_tilted);

/// Angle between the body's z axis and the vertical [rad], [0, pi].
[[nodiscard]] double tilt_angle_rad(const Eigen::Matrix3d& world_R_body);

}  // namespace extperfc::scan
