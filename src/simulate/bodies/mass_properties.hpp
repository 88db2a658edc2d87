#pragma once

#include <vector>

#include <Eigen/Core>

#include "extperfc/world/pose.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::simulate {

/// Mass, centre and inertia of a rigid object, in a frame of the caller's choice.
struct MassProperties {
  double mass_kg{0};
  Eigen::Vector3d com{Eigen::Vector3d::Zero()};            ///< [m]
  Eigen::Matrix3d inertia_kg_m2{Eigen::Matrix3d::Zero()};  ///< about `com`, along the frame's axes
};

/// The same object seen from another frame.
[[nodiscard]] MassProperties transformed(const Pose& target_T_source, const MassProperties& source);

/// Both objects as one; each may be without mass.
[[nodiscard]] MassProperties combined(const MassProperties& a, const MassProperties& b);

[[nodiscard]] MassProperties mass_properties(const Inertial& inertial);

/// Frame at the centre of mass whose axes are the principal axes of inertia.
struct PrincipalFrame {
  Pose frame_T_principal{Pose::Identity()};
  Eigen::Vector3d moments_kg_m2{Eigen::Vector3d::Ones()};  ///< each > 0
};
/// Moments below those of a ball of 2 mm and the same mass are raised to them: rounding in a description must
/// not make a link that spins without effort.
[[nodiscard]] PrincipalFrame principal_frame(const MassProperties& properties);

}  // namespace extperfc::simulate
