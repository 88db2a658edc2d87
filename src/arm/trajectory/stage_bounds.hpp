#pragma once

#include <array>

#include "extperfc/arm/joint_path.hpp"
#include "extperfc/arm/joint_trajectory.hpp"

namespace extperfc::arm {

/// Bezier points over a stage [offset, offset + length] of a rounded corner, with y in [0, 1] along the
/// stage. A phase that starts the stage with squared speed x and has acceleration u gives joint j
///   q'_j = direction_j + turn_j step(y)
///   a_j = q'' (x + 2 u length y) + q' u = u (direction_j + turn_j along(y)) + x turn_j across(y),
/// all cubic in y. A polynomial lies in the hull of its Bezier points: bounds on the four points are bounds
/// on the whole stage, linear in x and u.
struct StageShape {
  std::array<double, 4> step{};
  std::array<double, 4> along{};
  std::array<double, 4> across{};  ///< [1/rad]
};

[[nodiscard]] StageShape stage_shape(const PathPiece& piece, double offset, double length);

/// Closed interval per joint.
struct JointInterval {
  JointVector lower;
  JointVector upper;
};

/// Between which values the joints' accelerations stay during a phase [rad/s^2].
[[nodiscard]] JointInterval acceleration_range(const PathPiece& piece, const PathPhase& phase);

/// Largest |velocity| / limit over the joints and the phase; not less than the truth.
[[nodiscard]] double velocity_use(const PathPiece& piece, const PathPhase& phase, const JointVector& limit);

/// The same of accelerations.
[[nodiscard]] double acceleration_use(const PathPiece& piece, const PathPhase& phase,
                                      const JointVector& limit);

}  // namespace extperfc::arm
