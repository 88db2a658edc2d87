#pragma once

#include <Eigen/Core>

#include "arm/kinematics/geometry.hpp"

namespace extperfc::arm {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// x with m x = b by the square-root-free Cholesky factorization of a symmetric positive definite matrix
/// (Golub and Van Loan, "Matrix Computations", 4.1.2), which is overwritten; its lower half is read.
[[nodiscard]] Vector6 solve_in_place(Matrix6& m, Vector6 b);

/// The minimum-norm change of the joints that changes the task's rows by `wish`, damped:
/// J^T (J J^T + damping I)^-1 wish.
template <typename Rows>
[[nodiscard]] auto min_norm_change(const Rows& rows, const Vector6& wish, double damping) {
  Matrix6 normal;
  normal.noalias() = rows * rows.transpose();
  normal.diagonal().array() += damping;
  return (rows.transpose() * solve_in_place(normal, wish)).eval();
}

}  // namespace extperfc::arm
