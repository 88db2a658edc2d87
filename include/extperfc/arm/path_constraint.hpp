#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::arm {

struct Blocks;

/// What a tool has to keep; the numbers are those of extperfc/ToolConstraint.
enum class ToolConstraintKind {
  kKeepAxis = 0,         ///< an axis of the link keeps its direction: 2 equations
  kKeepPlane = 1,        ///< the link's origin stays in a plane: 1
  kKeepLine = 2,         ///< the link's origin stays on a line: 2
  kKeepOrientation = 3,  ///< the link keeps its orientation: 3
  kKeepRelative = 4,     ///< the link keeps its pose in another link's frame: 6
};

struct ToolConstraint {
  ToolConstraintKind kind{ToolConstraintKind::kKeepAxis};
  std::string link;
  std::string other_link;  ///< kKeepRelative only: the pose of `link` in this link's frame is kept
  /// Any length but 0. kKeepAxis: in the link's frame. kKeepPlane: the normal, kKeepLine: the direction, in
  /// the frame of the robot's root link.
  Eigen::Vector3d axis{Eigen::Vector3d::UnitZ()};
  /// A pose of the link that keeps the constraint: root_T_link, or other_T_link for kKeepRelative. None: the
  /// pose at PathConstraintParams::reference.
  std::optional<Pose> target{};
};

struct PathConstraintParams {
  std::vector<std::string> joints;  ///< of the group, in the order of every JointVector; 1 to kMaxJoints
  /// Positions [rad] or [m] of the other joints; 0, or the nearest limit, for those not named.
  std::map<std::string, double> fixed_positions;
  std::vector<ToolConstraint> constraints;  ///< at least one; all are kept at once
  /// Joint values that keep all constraints; may be empty when every constraint has a target.
  JointVector reference;
};

/// One value per equation, at most 6 per tool constraint.
inline constexpr int kMaxEquations = 24;
using ConstraintResidual = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxEquations, 1>;
/// Equations x joints.
using ConstraintJacobian =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxEquations, kMaxJoints>;

struct ProjectionParams {
  double tolerance{1e-8};  ///< of error() afterwards [m] or [rad], > 0
  int max_iterations{40};  ///< >= 1
};

/// Equations F(q) = 0 on the joint values of a group, from constraints on its tools.
///
/// The error of a constraint is a distance [m] for plane and line, an angle [rad] for axis and orientation,
/// the larger of both for the relative pose; that of several is the largest. F is made of the same
/// quantities, so that |F| of a constraint is its error: distances along two (line) directions, the rotation
/// vector for orientations, and for an axis the angle times the direction in which it has to rotate, as two
/// components across the target. Jacobians are analytic, from those of ArmChain; an axis that points exactly
/// opposite is the one place where they do not exist (F is then pi along the first component).
///
/// Immutable, a copy shares the data, may be used by any thread. Methods throw std::invalid_argument for
/// joint values of the wrong size. Some 1 us for seven joints.
class PathConstraint {
 public:
  /// Errors: an unknown link or joint (kNotFound); no constraint, too many equations, an axis of length 0, a
  /// value that is not finite, a target that is no rigid transform, neither a target nor a reference, a link
  /// that no joint of the group moves, both links of a relative pose the same (kInvalidArgument); a joint of
  /// a chain that follows another one (kUnsupported).
  [[nodiscard]] static Result<PathConstraint> make(const RobotModel& robot,
                                                   const PathConstraintParams& params);

  [[nodiscard]] int joint_count() const;
  [[nodiscard]] int equation_count() const;
  [[nodiscard]] const std::vector<ToolConstraint>& constraints() const;  ///< targets filled in, axes unit

  [[nodiscard]] ConstraintResidual residual(const JointVector& joints) const;
  /// dF/dq at `joints`, and F when asked for.
  [[nodiscard]] ConstraintJacobian jacobian(const JointVector& joints,
                                            ConstraintResidual* residual = nullptr) const;
  /// The largest error of all constraints [m] or [rad]; not finite for joint values that are not.
  [[nodiscard]] double error(const JointVector& joints) const;
  /// Of one constraint, by its index in constraints().
  [[nodiscard]] double error(const JointVector& joints, int constraint) const;

  /// A bound on error() at every state of the straight segment between two states, not at samples only.
  ///
  /// With x(t), t in [0, 1], a vector whose length gives the error (offset of the unit axis from its target,
  /// of the rotation matrix, of the position), a quadratic through the values at 0, 1/2 and 1 differs from x
  /// by at most max |x'''| max |t (t - 1/2) (t - 1)| / 6 = sqrt(3)/216 max |x'''|, and is itself nowhere
  /// longer than the longer end plus |x(1/2) - (x(0) + x(1)) / 2|. Third derivatives of points and directions
  /// carried by revolute joints with rates d_j (the segment's joint displacements) are at most (sum |d_j|)^3
  /// times the reach, or 1 for directions. For short segments the bound is close to the truth, as the last
  /// term shrinks with the third power.
  [[nodiscard]] double segment_error(const JointVector& from, const JointVector& to) const;
  /// The same, a third of the work, when error() at both ends is known to be at most `ends`, which is small:
  /// the bound is up to 2 `ends` larger.
  [[nodiscard]] double segment_error(const JointVector& from, const JointVector& to, double ends) const;

  /// How much error() can grow per radian (Euclidean over the joints) within `radius_rad` of `joints`: the
  /// Frobenius norm of the constraint's Jacobian and a bound on its change.
  [[nodiscard]] double steepness(const JointVector& joints, double radius_rad) const;

  /// The state near `joints` that keeps the constraints and the limits, by Newton's method with the
  /// pseudo-inverse, damped far from the solution (Levenberg-Marquardt), where joints that would leave their
  /// limits are held. Nothing when it does not converge. Limits may be infinite.
  [[nodiscard]] std::optional<JointVector> project(const JointVector& joints, const JointLimits& limits,
                                                   const ProjectionParams& params = {}) const;
  /// The part of `direction` along which F does not change to first order, joints at their limits held.
  [[nodiscard]] JointVector tangent(const JointVector& joints, const JointVector& direction,
                                    const JointLimits& limits) const;

 private:
  explicit PathConstraint(std::shared_ptr<const Blocks> blocks) : blocks_(std::move(blocks)) {}
  void check_size(const JointVector& joints) const;
  std::shared_ptr<const Blocks> blocks_;
};

}  // namespace extperfc::arm
