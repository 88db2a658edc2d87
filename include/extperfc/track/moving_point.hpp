#pragma once

#include <Eigen/Core>

namespace extperfc::track {

/// Kalman filter of a point that moves with a velocity that changes little: state (position, velocity), a
/// random acceleration that is constant between two updates (Bar-Shalom, Li and Kirubarajan, "Estimation
/// with Applications to Tracking and Navigation", 2001, sec. 6.3.2), measurements of the position.
class MovingPoint {
 public:
  using State = Eigen::Matrix<double, 6, 1>;       ///< x y z [m], their rates [m/s]
  using Covariance = Eigen::Matrix<double, 6, 6>;  ///< of the state

  /// At a measured position with its covariance [m, m^2]; the velocity is 0 with the standard deviation
  /// `speed_sigma_m_s` along each axis.
  MovingPoint(const Eigen::Vector3d& position_m, const Eigen::Matrix3d& covariance_m2,
              double speed_sigma_m_s);

  /// The state `dt_s` >= 0 later; `acceleration_m_s2` is the standard deviation of the acceleration along
  /// each axis.
  void predict(double dt_s, double acceleration_m_s2);

  /// As uncertain as if the velocity had changed at once `dt_s` >= 0 ago, with this standard deviation along
  /// each axis.
  void disturb(double dt_s, double speed_sigma_m_s);

  /// Takes a measurement. Precondition: `covariance_m2` is symmetric and positive definite.
  void correct(const Eigen::Vector3d& position_m, const Eigen::Matrix3d& covariance_m2);

  /// Squared Mahalanobis distance of a measurement from what is expected: chi-squared with 3 degrees of
  /// freedom when it is one of this point.
  [[nodiscard]] double distance2(const Eigen::Vector3d& position_m,
                                 const Eigen::Matrix3d& covariance_m2) const;

  [[nodiscard]] Eigen::Vector3d position_m() const { return state_.head<3>(); }
  [[nodiscard]] Eigen::Vector3d velocity_m_s() const { return state_.tail<3>(); }
  [[nodiscard]] const Covariance& covariance() const { return covariance_; }

 private:
  using Gain = Eigen::Matrix<double, 6, 3>;

  State state_;
  Covariance covariance_;
};

}  // namespace extperfc::track
