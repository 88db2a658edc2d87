#pragma once

#include <cmath>

#include "extperfc/arm/inverse_kinematics.hpp"

namespace extperfc::arm {

/// A rigid transform to rounding: finite, orthonormal, right-handed.
[[nodiscard]] inline bool is_rigid(const Pose& pose) {
  constexpr double kRounding = 1e-6;
  const Eigen::Matrix3d rotation = pose.linear();
  return pose.translation().allFinite() && rotation.allFinite() && rotation.determinant() > 0 &&
         (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kRounding;
}

[[nodiscard]] inline bool is_usable(const IkTolerance& tolerance) {
  return (tolerance.position_m.array() > 0).all() && (tolerance.orientation_rad.array() > 0).all();
}

[[nodiscard]] inline bool is_usable(const ArmChain& chain, const JointVector& seed) {
  return seed.size() == chain.joint_count() && seed.allFinite();
}

[[nodiscard]] inline IkFailure invalid_failure() {
  IkFailure failure;
  failure.reason = IkReason::kInvalid;
  failure.proven = true;
  return failure;
}

}  // namespace extperfc::arm
