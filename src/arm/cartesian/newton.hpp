#pragma once

#include "extperfc/arm/kinematics.hpp"

#include "arm/cartesian/tool_path.hpp"

namespace extperfc::arm {

/// The state near `guess` whose tip is at `target`, by damped least squares; with `limited` within the
/// limits, where joints that would leave them are held at them and the others do the rest.
/// False when it does not converge within a few steps: the target is far off, or the arm nearly singular.
[[nodiscard]] bool converge(const ArmChain& chain, const Pose& target, bool limited, JointVector& guess);

/// The minimum-norm change of the joints for `wish` [m], [rad], and the part of `urge` that does not move the
/// tip; joints at a limit that they would leave stand still.
[[nodiscard]] JointVector step_towards(const ArmChain& chain, const JointVector& joints, const Vector6& wish,
                                       const JointVector& urge);

/// A unit vector along which the joints move while the tip stands: the part of `near` in the null space of
/// the Jacobian. Zero when there is none.
[[nodiscard]] JointVector self_motion(const ArmChain& chain, const JointVector& joints,
                                      const JointVector& near);

/// Distance of each joint from the middle of its range, in halves of the range; 0 for joints without end.
[[nodiscard]] JointVector from_mid_range(const JointLimits& limits, const JointVector& joints);

}  // namespace extperfc::arm
