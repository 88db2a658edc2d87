#pragma once

#include <Eigen/Core>

namespace extperfc::arm {

/// Two 7-DOF arms and a gripper fit; vectors of this kind never touch the heap.
inline constexpr int kMaxJoints = 16;

/// One value per moving joint of a group, in the group's order: positions [rad] or [m], or their derivatives.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;

/// Closed interval of each joint of a group, same order and size [rad] or [m]; lower <= upper.
struct JointLimits {
  JointVector lower;
  JointVector upper;
};

}  // namespace extperfc::arm
