#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace extperfc::simulate {

/// What some joints do at one instant: vectors of one length, in the order of the joints.
struct JointMotion {
  Eigen::VectorXd position;      ///< [rad]
  Eigen::VectorXd velocity;      ///< [rad/s]
  Eigen::VectorXd acceleration;  ///< [rad/s^2]
};

/// Through what joints go, and when. Without a velocity the parts before and after it are straight; with
/// velocities at both ends a part is cubic, with accelerations too it is quintic.
struct JointKnot {
  double time_s{0};
  Eigen::VectorXd position;                     ///< [rad]
  std::optional<Eigen::VectorXd> velocity;      ///< [rad/s]
  std::optional<Eigen::VectorXd> acceleration;  ///< [rad/s^2]
};

/// Piecewise Hermite polynomial through knots, all joints at the same times.
class JointSpline {
 public:
  JointSpline() = default;
  /// `knots`: one or more, times increase strictly, vectors of one length.
  explicit JointSpline(const std::vector<JointKnot>& knots);

  [[nodiscard]] bool empty() const { return knot_times_.empty(); }
  [[nodiscard]] double start_s() const { return knot_times_.front(); }
  [[nodiscard]] double end_s() const { return knot_times_.back(); }
  /// Before the first and after the last knot the joints rest there. O(log knots).
  [[nodiscard]] JointMotion sample(double time_s) const;

 private:
  using Coefficients = Eigen::Matrix<double, Eigen::Dynamic, 6>;  ///< a row per joint, lowest power first

  std::vector<double> knot_times_;
  std::vector<Coefficients> parts_;  ///< one fewer than knots; polynomials of the time since their first knot
  Eigen::VectorXd first_;
  Eigen::VectorXd last_;
};

}  // namespace extperfc::simulate
