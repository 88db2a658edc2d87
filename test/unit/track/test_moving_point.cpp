// The filter against closed forms and against the statistics that it promises.
#include <cmath>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/track/moving_point.hpp"

namespace extperfc::track {
namespace {

const Eigen::Matrix3d kMeasured = Eigen::Vector3d(1e-4, 4e-4, 9e-4).asDiagonal();

Eigen::Vector3d noise(Rng& rng, const Eigen::Matrix3d& covariance) {
  return {rng.normal(0, std::sqrt(covariance(0, 0))), rng.normal(0, std::sqrt(covariance(1, 1))),
          rng.normal(0, std::sqrt(covariance(2, 2)))};
}

TEST(MovingPoint, RepeatedMeasurementsOfAStillPointAreAveraged) {
  Rng rng(1);
  const Eigen::Vector3d truth(0.4, -0.2, 0.9);
  const Eigen::Vector3d first = truth + noise(rng, kMeasured);
  Eigen::Vector3d sum = first;
  MovingPoint point(first, kMeasured, 0.0);  // without speed and acceleration the filter is the mean
  constexpr int kMeasurements = 40;
  for (int i = 1; i < kMeasurements; ++i) {
    const Eigen::Vector3d seen = truth + noise(rng, kMeasured);
    sum += seen;
    point.predict(0.1, 0.0);
    point.correct(seen, kMeasured);
  }
  EXPECT_LT((point.position_m() - sum / kMeasurements).norm(), 1e-12);
  const Eigen::Matrix3d covariance = point.covariance().topLeftCorner<3, 3>();
  EXPECT_TRUE(covariance.isApprox(kMeasured / kMeasurements, 1e-9)) << covariance;
}

TEST(MovingPoint, PredictionIsThatOfTheBook) {
  MovingPoint point({1, 2, 3}, kMeasured, 0.5);
  point.predict(0.2, 2.0);
  EXPECT_EQ(point.position_m(), Eigen::Vector3d(1, 2, 3));
  const auto& covariance = point.covariance();
  const double dt = 0.2;
  EXPECT_NEAR(covariance(0, 0), 1e-4 + 0.25 * dt * dt + 4.0 * std::pow(dt, 4) / 4, 1e-12);
  EXPECT_NEAR(covariance(0, 3), 0.25 * dt + 4.0 * std::pow(dt, 3) / 2, 1e-12);
  EXPECT_NEAR(covariance(3, 3), 0.25 + 4.0 * dt * dt, 1e-12);
}

TEST(MovingPoint, LearnsAVelocity) {
  Rng rng(2);
  const Eigen::Vector3d velocity(0.3, -0.1, 0.05);
  MovingPoint point(Eigen::Vector3d::Zero(), kMeasured, 0.5);
  for (int i = 1; i <= 60; ++i) {
    point.predict(0.1, 0.05);
    point.correct(0.1 * i * velocity + noise(rng, kMeasured), kMeasured);
  }
  const Eigen::Matrix3d covariance = point.covariance().bottomRightCorner<3, 3>();
  const Eigen::Vector3d error = point.velocity_m_s() - velocity;
  EXPECT_LT(error.dot(covariance.inverse() * error), 16.27);
  EXPECT_LT(error.norm(), 0.06);
}

/// Squared Mahalanobis distances of what the model itself generates have mean 3: normalized innovation
/// squared, Bar-Shalom et al. 2001, sec. 5.4.
TEST(MovingPoint, InnovationsAreConsistent) {
  constexpr int kRuns = 200;
  constexpr int kSteps = 30;
  constexpr double kDt = 0.1;
  constexpr double kAcceleration = 0.5;
  constexpr double kSpeed = 0.3;
  double sum = 0.0;
  Rng rng(3);
  const Eigen::Matrix3d speed = kSpeed * kSpeed * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d acceleration = kAcceleration * kAcceleration * Eigen::Matrix3d::Identity();
  for (int run = 0; run < kRuns; ++run) {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity = noise(rng, speed);
    MovingPoint point(position + noise(rng, kMeasured), kMeasured, kSpeed);
    for (int step = 0; step < kSteps; ++step) {
      const Eigen::Vector3d push = noise(rng, acceleration);
      position += kDt * velocity + 0.5 * kDt * kDt * push;
      velocity += kDt * push;
      const Eigen::Vector3d seen = position + noise(rng, kMeasured);
      point.predict(kDt, kAcceleration);
      sum += point.distance2(seen, kMeasured);
      point.correct(seen, kMeasured);
    }
  }
  constexpr double kSamples = static_cast<double>(kRuns) * kSteps;
  EXPECT_NEAR(sum / kSamples, 3.0, 4.0 * std::sqrt(2.0 * 3.0 / kSamples));  // variance of chi-squared: 2 n
}

TEST(MovingPoint, CovarianceStaysPositiveDefinite) {
  MovingPoint point(Eigen::Vector3d::Zero(), 1e4 * Eigen::Matrix3d::Identity(), 100.0);
  for (int i = 0; i < 2000; ++i) {
    point.predict(0.03, 0.01);
    point.correct({1, 1, 1}, 1e-8 * Eigen::Matrix3d::Identity());
  }
  const auto& covariance = point.covariance();
  EXPECT_TRUE(covariance.isApprox(covariance.transpose(), 1e-9));
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<MovingPoint::Covariance>(covariance).eigenvalues().minCoeff(), 0.0);
}

}  // namespace
}  // namespace extperfc::track
