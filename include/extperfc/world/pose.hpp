#pragma once

#include <Eigen/Geometry>

namespace extperfc {

/// Rigid transform; a variable is named target_T_source. Metres.
using Pose = Eigen::Isometry3d;

/// From a position [m] and roll, pitch, yaw about the fixed axes [rad] (URDF's and REP 103's convention).
[[nodiscard]] Pose make_pose(const Eigen::Vector3d& xyz_m,
                             const Eigen::Vector3d& rpy_rad = Eigen::Vector3d::Zero());

/// A pose on the floor.
struct Pose2 {
  double x{0};    ///< [m]
  double y{0};    ///< [m]
  double yaw{0};  ///< [rad], counter-clockwise
};

[[nodiscard]] bool is_finite(const Pose2& pose);

/// The pose of c in a, from that of b in a and of c in b: `a_T_c = compose(a_T_b, b_T_c)`.
[[nodiscard]] Pose2 compose(const Pose2& a_T_b, const Pose2& b_T_c);

[[nodiscard]] Pose2 inverse(const Pose2& pose);

/// Of the positions [m].
[[nodiscard]] double distance_m(const Pose2& a, const Pose2& b);

/// The pose of b in a, both given in the same third frame.
[[nodiscard]] Pose2 between(const Pose2& a, const Pose2& b);

/// A velocity on the floor, in the frame of the body that moves.
struct Twist2 {
  double vx{0};  ///< forward [m/s]
  double vy{0};  ///< to the left [m/s]
  double wz{0};  ///< counter-clockwise [rad/s]
};

[[nodiscard]] bool is_finite(const Twist2& twist);

[[nodiscard]] bool is_zero(const Twist2& twist);

/// The pose in space at z = 0.
[[nodiscard]] Pose to_pose(const Pose2& pose);

/// The pose seen from above: x, y and the direction of the x axis.
[[nodiscard]] Pose2 to_pose2(const Pose& pose);

/// The angle in (-pi, pi].
[[nodiscard]] double wrap_angle(double angle_rad);

/// `pose` after `twist` was held for `duration_s`: exact for a constant twist (the exponential map of SE(2)).
[[nodiscard]] Pose2 advance(const Pose2& pose, const Twist2& twist, double duration_s);

}  // namespace extperfc
