#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "extperfc/arm/path_constraint.hpp"

namespace extperfc::arm {

namespace {

/// Keeps redundant equations (a closed chain whose hands also keep level) from making the system singular.
constexpr double kMinDamping = 1e-12;
/// Damping per square of the residual: the step stays Newton's near the solution.
constexpr double kDamping = 1e-2;
constexpr double kMaxStepRad = 0.5;

using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxEquations, kMaxEquations>;

/// J^T (J J^T + damping)^-1 r over the columns that are not held.
JointVector pull_back(const ConstraintJacobian& jacobian, const ConstraintResidual& residual,
                      double damping) {
  Square square = jacobian * jacobian.transpose();
  square.diagonal().array() += damping;
  return jacobian.transpose() * square.ldlt().solve(residual);
}

/// Joints at a limit that `step` would leave; their columns become zero. True when there are new ones.
bool hold(const JointVector& joints, const JointVector& step, const JointLimits& limits,
          ConstraintJacobian* jacobian, JointVector* free) {
  bool any = false;
  for (Eigen::Index j = 0; j < joints.size(); ++j) {
    const bool outward =
        (step[j] > 0 && joints[j] >= limits.upper[j]) || (step[j] < 0 && joints[j] <= limits.lower[j]);
    if (!outward || (*free)[j] == 0.0) continue;
    jacobian->col(j).setZero();
    (*free)[j] = 0.0;
    any = true;
  }
  return any;
}

}  // namespace

std::optional<JointVector> PathConstraint::project(const JointVector& joints, const JointLimits& limits,
                                                   const ProjectionParams& params) const {
  check_size(joints);
  if (!joints.allFinite()) return std::nullopt;
  JointVector at = joints.cwiseMax(limits.lower).cwiseMin(limits.upper);
  for (int i = 0; i < params.max_iterations; ++i) {
    ConstraintResidual residual;
    ConstraintJacobian slopes = jacobian(at, &residual);
    if (residual.norm() <= params.tolerance) return at;
    const double damping = kMinDamping + kDamping * residual.squaredNorm();
    JointVector free = JointVector::Ones(at.size());
    JointVector step = -pull_back(slopes, residual, damping);
    while (hold(at, step, limits, &slopes, &free)) step = -pull_back(slopes, residual, damping);
    const double length = step.norm();
    if (length > kMaxStepRad) step *= kMaxStepRad / length;
    at = (at + step).cwiseMax(limits.lower).cwiseMin(limits.upper);
  }
  if (residual(at).norm() <= params.tolerance) return at;
  return std::nullopt;
}

JointVector PathConstraint::tangent(const JointVector& joints, const JointVector& direction,
                                    const JointLimits& limits) const {
  check_size(joints);
  check_size(direction);
  ConstraintJacobian slopes = jacobian(joints);
  JointVector free = JointVector::Ones(joints.size());
  JointVector along = direction;
  do {
    const JointVector wanted = direction.cwiseProduct(free);
    along = wanted - pull_back(slopes, slopes * wanted, kMinDamping);
  } while (hold(joints, along, limits, &slopes, &free));
  return along;
}

}  // namespace extperfc::arm
