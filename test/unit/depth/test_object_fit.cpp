// Pose and size of standing cubes, spheres and cones from rendered depth.
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "extperfc/depth/object_fit.hpp"

#include "test/unit/depth/standing_object.hpp"

namespace extperfc::depth {
namespace {

constexpr std::array<FitShape, 3> kShapes{FitShape::kCube, FitShape::kSphere, FitShape::kCone};
constexpr std::array<const char*, 3> kNames{"cube", "sphere", "cone"};

Standing random_object(FitShape shape, Rng& rng) {
  const double width = rng.uniform(0.04, 0.08);
  return {shape, width, width * rng.uniform(1.2, 1.8), rng.uniform(0, 1.5)};
}

Eigen::Vector3d size_of(const Standing& object) {
  return {object.width_m, object.width_m, object.height()};
}

/// Angle between a cube's fitted face and its nearest true one [rad].
double yaw_error(const View& view, const ObjectFit& fit, double yaw_rad) {
  const Eigen::Vector3d x = view.camera_T_world.linear().transpose() * fit.camera_T_object.linear().col(0);
  return std::abs(std::remainder(std::atan2(x.y(), x.x()) - yaw_rad, M_PI / 2));
}

TEST(ObjectFit, FindsTheExactObjectInImagesWithoutNoise) {
  Rng rng(11);
  for (int i = 0; i < 18; ++i) {
    const Standing object = random_object(kShapes[i % 3], rng);
    const View view = view_of(object, rng.uniform(0.3, 0.8), rng.uniform(0.5, 1.1), rng, std::nullopt);
    const auto fit = fit_object(view.depth.view(), fit_camera(), view.box, object.shape, view.up());
    ASSERT_TRUE(fit) << fit.error().message << ", seed 11, case " << i;
    // What is left is the rounding to 1 mm.
    EXPECT_LT((fit->camera_T_object.translation() - view.middle(object)).norm(), 0.0008) << "case " << i;
    EXPECT_LT((fit->size_m - size_of(object)).cwiseAbs().maxCoeff(), 0.0015) << "case " << i;
    EXPECT_NEAR((fit->camera_T_object.linear().col(2) - view.up()).norm(), 0, 0.005);
    EXPECT_NEAR((fit->support - view.camera_T_world.translation()).norm(), 0, 0.001);
    if (object.shape == FitShape::kCube) {
      EXPECT_LT(yaw_error(view, *fit, object.yaw_rad), 0.02);
    }
  }
}

struct Accuracy {
  double error_m{0}, worst_m{0}, size_m{0}, surprise{0};
  int found{0};
};

/// Objects at one distance, as the D435i and a detector see them.
Accuracy measure(FitShape shape, double distance_m, int count, Rng& rng) {
  Accuracy sum;
  for (int i = 0; i < count; ++i) {
    const Standing object = random_object(shape, rng);
    const View view = view_of(object, distance_m, rng.uniform(0.5, 1.0), rng, StereoNoiseModel{});
    const Box2 box = jittered(view.box, rng);
    const auto fit = fit_object(view.depth.view(), fit_camera(), box, shape, view.up());
    if (!fit) continue;
    const Eigen::Vector3d error = fit->camera_T_object.translation() - view.middle(object);
    ++sum.found;
    sum.error_m += error.norm() / count;
    sum.worst_m = std::max(sum.worst_m, error.norm());
    sum.size_m += std::abs(fit->size_m.x() - object.width_m) / count;
    sum.surprise += error.dot(fit->covariance.ldlt().solve(error)) / count;
  }
  return sum;
}

/// The error in sight of the camera's noise: some millimetres and a fraction of one pixel's standard
/// deviation.
TEST(ObjectFit, IsAsAccurateAsTheCamerasNoiseAllows) {
  Rng rng(12);
  constexpr int kCount = 10;
  for (const double distance : {0.3, 0.5, 0.8, 1.2})
    for (std::size_t i = 0; i < kShapes.size(); ++i) {
      const Accuracy found = measure(kShapes[i], distance, kCount, rng);
      const double sigma = StereoNoiseModel{}.sigma(distance);
      std::printf(
          "%-6s %.1f m: found %d of %d, mean error %.2f mm, worst %.2f mm, width %.2f mm, surprise %.1f\n",
          kNames[i], distance, found.found, kCount, 1e3 * found.error_m, 1e3 * found.worst_m,
          1e3 * found.size_m, found.surprise);
      EXPECT_EQ(found.found, kCount);
      EXPECT_LT(found.error_m, 0.0005 + sigma) << kNames[i] << " " << distance;
      EXPECT_LT(found.worst_m, 0.001 + 3 * sigma) << kNames[i] << " " << distance;
      // Three numbers: 3 on average where the covariance is right; an error of the covariance by 3 is far
      // off.
      EXPECT_LT(found.surprise, 9) << kNames[i] << " " << distance;
    }
}

TEST(ObjectFit, CovarianceIsSymmetricAndPositiveDefinite) {
  Rng rng(13);
  for (int i = 0; i < 9; ++i) {
    const Standing object = random_object(kShapes[i % 3], rng);
    const View view = view_of(object, rng.uniform(0.3, 1.0), 0.8, rng, StereoNoiseModel{});
    const auto fit = fit_object(view.depth.view(), fit_camera(), view.box, object.shape, view.up());
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_LT((fit->covariance - fit->covariance.transpose()).norm(), 1e-12);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(fit->covariance).eigenvalues().minCoeff(), 0);
    EXPECT_GT(fit->size_sigma_m, 0);
    EXPECT_LT(fit->size_sigma_m, 0.02);
  }
}

TEST(ObjectFit, BothFormatsGiveTheSame) {
  Rng rng(14);
  const Standing object{FitShape::kCone, 0.06, 0.09, 0};
  const View view = view_of(object, 0.4, 0.8, rng, std::nullopt);
  DepthImage metres(640, 480, PixelFormat::kDepth32M, 5, 3);
  const ImageView mm = view.depth.view();
  metres.fill([&](int x, int y) {
    std::uint16_t value = 0;
    std::memcpy(&value, mm.row(y) + 2 * static_cast<std::size_t>(x), sizeof value);
    return value == 0 ? std::numeric_limits<double>::quiet_NaN() : 0.001 * value;
  });
  const auto a = fit_object(mm, fit_camera(), view.box, object.shape, view.up());
  const auto b = fit_object(metres.view(), fit_camera(), view.box, object.shape, view.up());
  ASSERT_TRUE(a && b);
  EXPECT_LT((a->camera_T_object.translation() - b->camera_T_object.translation()).norm(), 1e-6);
}

TEST(ObjectFit, TakesTheTableAndNotTheFloorBehindItsEdge) {
  Rng rng(15);
  for (int i = 0; i < 9; ++i) {
    const Standing object{kShapes[i % 3], 0.05, 0.08, 0.4};
    const View view = view_of(object, 0.5, 0.7, rng, StereoNoiseModel{}, 0.06);  // a table of 12 cm
    const auto fit = fit_object(view.depth.view(), fit_camera(), view.box, object.shape, view.up());
    ASSERT_TRUE(fit) << fit.error().message << ", case " << i;
    EXPECT_LT((fit->camera_T_object.translation() - view.middle(object)).norm(), 0.004) << "case " << i;
  }
}

TEST(ObjectFit, SmallErrorOfUpIsMendedByTheSupport) {
  Rng rng(16);
  const Standing object{FitShape::kCube, 0.05, 0.05, 0.3};
  const View view = view_of(object, 0.4, 0.8, rng, StereoNoiseModel{});
  const Eigen::Vector3d up = Eigen::AngleAxisd(0.02, Eigen::Vector3d(1, 0.5, 0).normalized()) * view.up();
  const auto fit = fit_object(view.depth.view(), fit_camera(), view.box, object.shape, up);
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_LT(std::acos(fit->camera_T_object.linear().col(2).dot(view.up())), 0.008);
  EXPECT_LT((fit->camera_T_object.translation() - view.middle(object)).norm(), 0.002);
}

TEST(ObjectFit, ReportsWhyThereIsNothing) {
  Rng rng(17);
  const Standing object{FitShape::kCube, 0.05, 0.05, 0.3};
  const View view = view_of(object, 0.4, 0.8, rng, std::nullopt, 10, 5);
  const auto reason = [&](const ImageView& depth, const Box2& box, FitShape shape) {
    const auto fit = fit_object(depth, fit_camera(), box, shape, view.up());
    EXPECT_FALSE(fit);
    return fit ? std::string() : fit.error().message;
  };
  const DepthImage empty(640, 480);
  EXPECT_EQ(reason(empty.view(), view.box, object.shape), "no depth measurements in the box");
  // Beside the object is nothing but the table.
  Box2 beside = view.box;
  const float shift = beside.x_min > 320 ? -2.5F * beside.width() : 2.5F * beside.width();
  beside.x_min += shift;
  beside.x_max += shift;
  EXPECT_NE(reason(view.depth.view(), beside, object.shape).find("pixels rise above the support"),
            std::string::npos);
  // A cube is no sphere and no cone.
  EXPECT_NE(reason(view.depth.view(), view.box, FitShape::kSphere).find("does not match a sphere"),
            std::string::npos);
  DepthImage wall(640, 480);
  wall.fill([](int, int) { return 0.5; });  // upright to the camera's axis: no level support
  EXPECT_NE(reason(wall.view(), view.box, object.shape).find("no level support"), std::string::npos);
}

TEST(ObjectFit, RefusesBadInput) {
  Rng rng(18);
  const Standing object{FitShape::kSphere, 0.05, 0.05, 0};
  const View view = view_of(object, 0.4, 0.8, rng, std::nullopt);
  const auto code = [&](const ImageView& depth, const Box2& box, const Eigen::Vector3d& up,
                        const ObjectFitParams& params) {
    const auto fit = fit_object(depth, fit_camera(), box, object.shape, up, params);
    return fit ? ErrorCode::kFailed : fit.error().code;
  };
  const ImageView good = view.depth.view();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(code({}, view.box, view.up(), {}), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code(good, {10, 10, 10, 20}, view.up(), {}), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code(good, {nan, 10, 20, 20}, view.up(), {}), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code(good, view.box, Eigen::Vector3d::Zero(), {}), ErrorCode::kInvalidArgument);
  ObjectFitParams params;
  params.min_fitting = 0;
  EXPECT_EQ(code(good, view.box, view.up(), params), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code(good, {-500, -500, -400, -400}, view.up(), {}), ErrorCode::kNotFound);
}

TEST(ObjectFit, SurvivesAnyImage) {
  Rng rng(19);
  DepthImage image(640, 480);
  for (int i = 0; i < 30; ++i) {
    const double scale = rng.uniform(0.1, 3);
    image.fill([&](int, int) { return rng.chance(0.3) ? 0.0 : rng.uniform(0, scale); });
    const Box2 box{static_cast<float>(rng.uniform(-50, 600)), static_cast<float>(rng.uniform(-50, 400)),
                   static_cast<float>(rng.uniform(0, 700)), static_cast<float>(rng.uniform(0, 500))};
    const auto fit = fit_object(image.view(), fit_camera(), box, kShapes[i % 3], -Eigen::Vector3d::UnitY());
    if (fit) {
      EXPECT_TRUE(fit->camera_T_object.matrix().allFinite() && fit->covariance.allFinite());
    }
  }
}

}  // namespace
}  // namespace extperfc::depth
