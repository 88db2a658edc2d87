#include <cmath>
#include <cstdio>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/depth/box_depth.hpp"

#include "test/unit/depth/standing_object.hpp"

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
  EXPECT_NEAR(object.center_covariance(0, 2), 0.0, 1e-12);
}

TEST(Locate, TheSurfacesCovarianceHoldsDepthAndBoxAlone) {
  const Box2 box{290, 190, 350,
                 290};  // 60 x 100 px at the principal point: its middle is known to 1.8 and 3 px
  const auto object = locate(camera(), box, {2.0, 0.01, 100, 1.0});
  const Eigen::Vector3d sigma_m(1.8 * 2.0 / 600.0, 3.0 * 2.0 / 500.0, 0.01);
  const Eigen::Matrix3d expected = sigma_m.cwiseAbs2().asDiagonal();
  EXPECT_LT((object.surface_covariance - expected).norm(), 1e-9) << object.surface_covariance;
}

TEST(Locate, TheCentresCovarianceGrowsWithTheExtentThatNobodySaw) {
  const BoxDepth depth{2.0, 0.0, 100, 1.0};                              // an exact depth
  const auto small = locate(camera(), {305, 227.5, 335, 252.5}, depth);  // 0.1 m
  const auto large = locate(camera(), {290, 215, 350, 265}, depth);      // 0.2 m
  EXPECT_DOUBLE_EQ(small.surface_covariance(2, 2), 0.0);
  const double small_m = std::sqrt(small.center_covariance(2, 2));
  // A centre that lies anywhere between the surface and the full extent behind it: 0.1 m / sqrt(12) = 0.029
  // m.
  EXPECT_GT(small_m, 0.01);
  EXPECT_LT(small_m, 0.029);
  EXPECT_NEAR(std::sqrt(large.center_covariance(2, 2)), 2.0 * small_m, 1e-6);
  for (const auto* object : {&small, &large})
    for (int i = 0; i < 2; ++i) EXPECT_GT(object->center_covariance(i, i), object->surface_covariance(i, i));
}

constexpr int kViews = 15;  // per shape and distance

/// Mean of error^T covariance^-1 error of the centre of standing objects of 4 to 20 cm.
double surprise(FitShape shape, double distance_m, Rng& rng) {
  double sum = 0;
  for (int i = 0; i < kViews; ++i) {
    const double width = rng.uniform(0.04, std::min(0.2, 0.25 * distance_m));
    const Standing object{shape, width, width * rng.uniform(1.2, 1.8), rng.uniform(0, 1.5)};
    const View view = view_of(object, distance_m, rng.uniform(0.3, 1.0), rng, StereoNoiseModel{});
    const Box2 box = jittered(view.box, rng);
    const auto depth = estimate_depth(view.depth.view(), box, {});
    if (!depth) return INFINITY;
    const Object3 found = locate(fit_camera(), box, *depth);
    const Eigen::Vector3d error = found.center - view.middle(object);
    sum += error.dot(found.center_covariance.ldlt().solve(error)) / kViews;
  }
  return sum;
}

/// Three numbers: 3 on average over the shapes where the covariance is right. The shape is not known, so that
/// one shape alone may be off by more; 12 are two standard deviations.
TEST(Locate, TheCentresErrorIsAsLargeAsItsCovarianceSays) {
  Rng rng(23);
  double mean = 0;
  for (const auto shape : {FitShape::kCube, FitShape::kSphere, FitShape::kCone})
    for (const double distance_m : {0.3, 0.8, 1.5}) {
      const double found = surprise(shape, distance_m, rng);
      std::printf("shape %d at %.1f m: %.1f\n", static_cast<int>(shape), distance_m, found);
      EXPECT_LT(found, 12.0) << "seed 23, shape " << static_cast<int>(shape) << " at " << distance_m << " m";
      mean += found / 9;
    }
  EXPECT_GT(mean, 1.0) << "seed 23";
  EXPECT_LT(mean, 4.5) << "seed 23";
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
    for (const auto& covariance : {object.surface_covariance, object.center_covariance}) {
      EXPECT_EQ(covariance, covariance.transpose()) << "seed 6, case " << i;
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
      const double largest = solver.eigenvalues().maxCoeff();
      EXPECT_GE(solver.eigenvalues().minCoeff(), -1e-12 * largest) << "seed 6, case " << i;
      EXPECT_GT(largest, 0.0);
    }
  }
}

TEST(Locate, DepthErrorPointsAlongTheRay) {
  const Box2 box{600, 440, 606, 446};  // far from the axis, small: depth dominates
  const auto object = locate(camera(), box, {2.0, 0.3, 30, 1.0});
  for (const auto& covariance : {object.surface_covariance, object.center_covariance}) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
    const Eigen::Vector3d longest = solver.eigenvectors().col(2);
    EXPECT_NEAR(std::abs(longest.dot(object.surface.normalized())), 1.0, 1e-3);
    EXPECT_NEAR(std::sqrt(covariance(2, 2)), 0.3, 0.01);  // along the optical axis: sigma of the depth
  }
}

}  // namespace
}  // namespace extperfc::depth
