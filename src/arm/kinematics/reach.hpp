#pragma once

#include "extperfc/arm/inverse_kinematics.hpp"

#include "arm/kinematics/geometry.hpp"

namespace extperfc::arm {

/// Of a geometry whose `reach` is not set yet; `limits` of the prismatic joints. Some 0.1 ms.
[[nodiscard]] Reach find_reach(const ChainGeometry& geometry, const JointLimits& limits);

/// True: no position of the joints brings the tip to `target` (root_T_tip) within the tolerance, by the
/// triangle inequality.
[[nodiscard]] bool is_beyond(const Reach& reach, const Pose& target, const IkTolerance& tolerance);

}  // namespace extperfc::arm
