#include "extperfc/track/moving_point.hpp"

#include <Eigen/Cholesky>

namespace extperfc::track {

MovingPoint::MovingPoint(const Eigen::Vector3d& position_m, const Eigen::Matrix3d& covariance_m2,
                         double speed_sigma_m_s)
    : state_(State::Zero()), covariance_(Covariance::Zero()) {
  state_.head<3>() = position_m;
  covariance_.topLeftCorner<3, 3>() = covariance_m2;
  covariance_.bottomRightCorner<3, 3>().diagonal().setConstant(speed_sigma_m_s * speed_sigma_m_s);
}

void MovingPoint::predict(double dt_s, double acceleration_m_s2) {
  Covariance transition = Covariance::Identity();
  transition.topRightCorner<3, 3>().diagonal().setConstant(dt_s);
  Gain gain = Gain::Zero();
  gain.topRows<3>().diagonal().setConstant(0.5 * dt_s * dt_s);
  gain.bottomRows<3>().diagonal().setConstant(dt_s);
  state_ = transition * state_;
  covariance_ = transition * covariance_ * transition.transpose() +
                acceleration_m_s2 * acceleration_m_s2 * gain * gain.transpose();
}

void MovingPoint::disturb(double dt_s, double speed_sigma_m_s) {
  Gain gain = Gain::Zero();
  gain.topRows<3>().diagonal().setConstant(dt_s);
  gain.bottomRows<3>().setIdentity();
  covariance_ += speed_sigma_m_s * speed_sigma_m_s * gain * gain.transpose();
}

/// Joseph's form: the covariance stays symmetric and positive definite.
void MovingPoint::correct(const Eigen::Vector3d& position_m, const Eigen::Matrix3d& covariance_m2) {
  const Eigen::Matrix3d innovation = covariance_.topLeftCorner<3, 3>() + covariance_m2;
  const Gain gain = innovation.ldlt().solve(covariance_.topRows<3>()).transpose();
  state_ += gain * (position_m - state_.head<3>());
  Covariance kept = Covariance::Identity();
  kept.leftCols<3>() -= gain;
  covariance_ = kept * covariance_ * kept.transpose() + gain * covariance_m2 * gain.transpose();
}

double MovingPoint::distance2(const Eigen::Vector3d& position_m, const Eigen::Matrix3d& covariance_m2) const {
  const Eigen::Matrix3d innovation = covariance_.topLeftCorner<3, 3>() + covariance_m2;
  const Eigen::Vector3d residual = position_m - state_.head<3>();
  return residual.dot(innovation.ldlt().solve(residual));
}

}  // namespace extperfc::track
