#include <cmath>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/depth/box_depth.hpp"

namespace extperfc::depth {
namespace {

CameraModel camera() {
  return {640, 480, 600.0, 500.0, 319.5, 239.5, {}};
}

TEST(Locate, BoxAtThePrincipalPoint) {
  const Box2 box{290, 215, 350,
                 265};  // 60 x 50 px around the edge coordinate (320, 240) = pixel centre 319.5, 239.5
  const auto object = locate(camera(), box, {2.0, 0.01, 100, 1.0});
  EXPECT_NEAR((object.surface - Eigen::Vector3d(0, 0, 2.0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((object.size - Eigen::Vector3d(0.2, 0.2, 0.2)).norm(), 0.0, 1e-6);
  EXPECT_NEAR((object.center - Eigen::Vector3d(0, 0, 2.1)).norm(), 0.0, 1e-6);
  EXPECT_NEAR(object.covariance(0, 2), 0.0, 1e-12);
}

TEST(Locate, CenterLiesOnTheRayBehindTheSurface) {
  Rng rng(5);
  for (int i = 0; i < 500; ++i) {
    const double u = rng.uniform(0, 640);
    const double v = rng.uniform(0, 480);
    const double half = rng.uniform(2, 100);
    const Box2 box{static_cast<float>(u - half), static_cast<float>(v - half), static_cast<float>(u + half),
                   static_cast<float>(v + half)};
    const auto object = locate(camera(), box, {rng.uniform(0.2, 5.0), 0.01, 50, 1.0});
    const Eigen::Vector3d push = object.center - object.surface;
    EXPECT_NEAR(push.norm(), 0.5 * object.size.z(), 1e-9) << "seed 5, case " << i;
    EXPECT_NEAR(push.normalized().dot(object.surface.normalized()), 1.0, 1e-9) << "seed 5, case " << i;
    EXPECT_LE(object.size.z(), std::min(object.size.x(), object.size.y()));
  }
}

TEST(Locate, CovarianceIsSymmetricAndPositiveSemiDefinite) {
  Rng rng(6);
  for (int i = 0; i < 2000; ++i) {
    auto lens = camera();
    lens.distortion = {rng.uniform(-0.1, 0.1), 0, rng.uniform(-1e-3, 1e-3), 0, 0};
    const auto edge = [&] { return static_cast<float>(rng.uniform(-100, 800)); };
    const Box2 box{edge(), edge(), edge(), edge()};
    const double sigma_m = rng.chance(0.1) ? 0.0 : rng.uniform(0.0, 0.5);
    const auto object = locate(lens, box, {rng.uniform(0.11, 10.0), sigma_m, 50, 1.0});
    EXPECT_EQ(object.covariance, object.covariance.transpose()) << "seed 6, case " << i;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(object.covariance);
    const double largest = solver.eigenvalues().maxCoeff();
    EXPECT_GE(solver.eigenvalues().minCoeff(), -1e-12 * largest) << "seed 6, case " << i;
    EXPECT_GT(largest, 0.0);
  }
}

TEST(Locate, DepthErrorPointsAlongTheRay) {
  const Box2 box{600, 440, 606, 446};  // far from the axis, small: depth dominates
  const auto object = locate(camera(), box, {2.0, 0.3, 30, 1.0});
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(object.covariance);
  const Eigen::Vector3d longest = solver.eigenvectors().col(2);
  EXPECT_NEAR(std::abs(longest.dot(object.surface.normalized())), 1.0, 1e-3);
  EXPECT_NEAR(std::sqrt(object.covariance(2, 2)), 0.3, 0.01);  // along the optical axis: sigma of the depth
}

}  // namespace
}  // namespace extperfc::depth
