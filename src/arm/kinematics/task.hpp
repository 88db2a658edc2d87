#pragma once

#include <chrono>

#include <Eigen/Core>

#include "extperfc/arm/inverse_kinematics.hpp"

#include "arm/kinematics/geometry.hpp"
#include "arm/kinematics/rotation.hpp"

namespace extperfc::arm {

/// The moment at which a search gives up; an infinite or very long time never comes.
class Deadline {
 public:
  using Clock = std::chrono::steady_clock;
  explicit Deadline(double timeout_s) {
    constexpr double kLongest = 1e6;
    if (timeout_s < kLongest)
      end_ = Clock::now() +
             std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(timeout_s));
  }
  [[nodiscard]] bool passed() const { return end_ != Clock::time_point::max() && Clock::now() >= end_; }

 private:
  Clock::time_point end_{Clock::time_point::max()};
};

template <int N>
struct Bounds {
  Joints<N> lower, upper;  ///< +-infinity: none

  [[nodiscard]] Joints<N> clamp(const Joints<N>& q) const { return q.cwiseMax(lower).cwiseMin(upper); }
};

/// What the tip is to do: errors are those of target_T_tip, [m] and rotation vector [rad].
struct Task {
  static constexpr double kTight = 1e-3;  ///< tolerances up to this aim at the target itself, ...
  static constexpr double kInset = 1e-4;  ///< ... wider ones at their nearest edge, this far inside

  Task(const Pose& target, const IkTolerance& allowed, const ChainGeometry& geometry)
      : base(ChainLink{target.linear().transpose(), -(target.linear().transpose() * target.translation())} *
             geometry.links[0]) {
    tolerance << allowed.position_m, allowed.orientation_rad;
    slack = (tolerance.array() > kTight).select(tolerance.array() - kInset, 0.0);
    exact = slack.maxCoeff() == 0;
  }

  [[nodiscard]] bool reached(const Vector6& error) const {
    return (error.array().abs() <= tolerance.array()).all();
  }

  ChainLink base;     ///< target_T_root, up to the first joint
  Vector6 tolerance;  ///< > 0; infinity: free
  Vector6 slack;      ///< an error below this costs nothing
  bool exact{true};   ///< no slack at all
};

/// Error, cost and their derivatives at one configuration.
template <int N>
struct Evaluation {
  Placement<N> at;
  Vector6 error;
  Vector6 residual;  ///< the part of the error that costs
  double cost{0};    ///< squared norm of the residual

  void compute(const ChainGeometry& geometry, const Task& task, const Joints<N>& q) {
    place<N>(geometry, task.base, q, at);
    error << at.position, rotation_vector(at.rotation);
    residual = error;
    if (!task.exact) residual -= error.cwiseMax(-task.slack).cwiseMin(task.slack);
    cost = residual.squaredNorm();
  }

  /// Of the residual. Rows within the slack are zero. Without slack the rotation's rows are the angular
  /// velocity: the steps to a vanishing error are the same, since the error is an eigenvector of the exact
  /// derivative.
  void derivative(const ChainGeometry& geometry, const Task& task, Columns<N>& out) const {
    chain_jacobian<N>(geometry, at, out);
    if (task.exact) return;
    const Columns<N> angular = out;
    out.template bottomRows<3>().noalias() =
        vector_change(error.template tail<3>()) * angular.template bottomRows<3>();
    for (int row = 0; row < 6; ++row)
      if (task.slack[row] > 0 && residual[row] == 0) out.row(row).setZero();
  }
};

using AnyBounds = Bounds<Eigen::Dynamic>;
using AnyEvaluation = Evaluation<Eigen::Dynamic>;

}  // namespace extperfc::arm
