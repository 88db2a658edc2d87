// Errors of the depth image against their closed forms.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "simulate/render/depth_noise.hpp"
#include "test/unit/simulate/render/small_world.hpp"

namespace extperfc::simulate {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr double kPixels = kWidth * kHeight;

/// Camera whose pixels are as large as those of its infrared pair: shifts are disparities.
CameraParams params_with_noise() {
  CameraParams params = exact_camera(kWidth, kHeight, 424);
  params.depth = {};
  params.depth.hole_probability = 0;
  params.depth.edge_holes = 0;
  return params;
}

template <typename Depth>
CameraImages measured(const CameraParams& params, Depth depth, std::uint32_t key = 1) {
  CameraImages images;
  images.width = kWidth;
  images.height = kHeight;
  images.true_depth_m.resize(kWidth * kHeight);
  images.depth_mm.resize(kWidth * kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      images.true_depth_m[static_cast<std::size_t>(y * kWidth + x)] = static_cast<float>(depth(x, y));
  DepthNoise noise;
  noise.apply(params, {key, 77}, images);
  return images;
}

double sigma_mm(const CameraImages& images, double truth_mm) {
  double sum2 = 0;
  for (const auto depth : images.depth_mm) sum2 += (depth - truth_mm) * (depth - truth_mm);
  return std::sqrt(sum2 / kPixels);
}

/// sigma(z) = z^2 subpixel / (focal baseline), and what the steps of disparity and of the unit add.
double expected_mm(const DepthNoiseParams& p, double z) {
  const double per_px = z * z / (p.focal_px * p.baseline_m);
  const double variance = std::pow(per_px * p.subpixel_px, 2) +
                          std::pow(per_px * p.disparity_step_px, 2) / 12 + p.quantum_m * p.quantum_m / 12;
  return 1000 * std::sqrt(variance);
}

TEST(DepthNoise, SigmaIsTheClosedFormAtEveryDistance) {
  auto params = params_with_noise();
  params.depth.correlation_px = 1;
  params.depth.disparity_step_px = 0;
  for (const double z : {0.5, 1.0, 2.0, 4.0}) {
    const auto images = measured(params, [&](int, int) { return z; });
    // An estimate of sigma from n values has a relative standard deviation of 1 / sqrt(2 n) = 0.26 %, four of
    // them; 1/d is not linear in d: (sigma_d / d)^2 = 0.1 % at 4 m; the bytes of the noise: 0.1 %.
    EXPECT_NEAR(sigma_mm(images, 1000 * z) / expected_mm(params.depth, z), 1.0, 0.013) << z << " m";
  }
}

TEST(DepthNoise, StepsOfDisparityAddLittle) {
  auto params = params_with_noise();
  params.depth.correlation_px = 1;
  for (const double z : {0.5, 1.0, 2.0, 4.0}) {
    const auto images = measured(params, [&](int, int) { return z; });
    // Steps of disparity and millimetres beat: up to 2 % of the standard deviation.
    EXPECT_NEAR(sigma_mm(images, 1000 * z) / expected_mm(params.depth, z), 1.0, 0.03) << z << " m";
  }
}

TEST(DepthNoise, CorrelatedNoiseHasTheSameSigmaAndMovesInPatches) {
  const auto params = params_with_noise();
  const auto images = measured(params, [](int, int) { return 2.0; });
  // About n / 49 patches: 1.8 %, four of them.
  EXPECT_NEAR(sigma_mm(images, 2000) / expected_mm(params.depth, 2.0), 1.0, 0.08);
  double near = 0;
  double far = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x + 20 < kWidth; ++x) {
      const auto* row = images.depth_mm.data() + y * kWidth + x;
      near += (row[0] - 2000.0) * (row[1] - 2000.0);
      far += (row[0] - 2000.0) * (row[20] - 2000.0);
    }
  }
  EXPECT_GT(near / kPixels, 0.7 * std::pow(expected_mm(params.depth, 2.0), 2));
  EXPECT_LT(std::abs(far) / kPixels, 0.1 * std::pow(expected_mm(params.depth, 2.0), 2));
}

TEST(DepthNoise, NoNoiseIsTheTruthInMillimetres) {
  const auto params = exact_camera(kWidth, kHeight, 424);
  const auto images = measured(params, [](int x, int y) { return 0.5 + 0.001 * x + 0.002 * y; });
  for (std::size_t i = 0; i < images.depth_mm.size(); ++i)
    ASSERT_EQ(images.depth_mm[i], static_cast<int>(images.true_depth_m[i] * 1000 + 0.5F));
}

TEST(DepthNoise, UnitIsTheQuantum) {
  auto params = params_with_noise();
  params.depth.quantum_m = 0.005;
  const auto images = measured(params, [](int, int) { return 3.0; });
  for (const auto depth : images.depth_mm) ASSERT_EQ(depth % 5, 0);
}

TEST(DepthNoise, NothingOutsideItsRange) {
  const auto params = params_with_noise();
  for (const double z : {0.0, 0.12, 12.0, 100.0}) {
    const auto images = measured(params, [&](int, int) { return z; });
    EXPECT_EQ(*std::max_element(images.depth_mm.begin(), images.depth_mm.end()), 0) << z << " m";
  }
  const auto at_limit = measured(params, [](int, int) { return 9.9; });
  EXPECT_LE(*std::max_element(at_limit.depth_mm.begin(), at_limit.depth_mm.end()), 10000);
}

TEST(DepthNoise, HolesAreAsManyAsAsked) {
  auto params = params_with_noise();
  params.depth.hole_probability = 0.02;
  const auto images = measured(params, [](int, int) { return 1.0; });
  const auto holes = static_cast<double>(std::count(images.depth_mm.begin(), images.depth_mm.end(), 0));
  EXPECT_NEAR(holes, 0.02 * kPixels, 5 * std::sqrt(0.02 * 0.98 * kPixels));
}

TEST(DepthNoise, TheRightEyesShadowLiesLeftOfNearObjects) {
  auto params = params_with_noise();
  params.depth.edge_holes = 0.4;  // all of the shadow
  const auto images = measured(params, [](int x, int) { return x >= 160 && x < 220 ? 1.0 : 2.0; });
  const auto lost = [&](int from, int to) {
    int count = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = from; x < to; ++x)
        count += images.depth_mm[static_cast<std::size_t>(y * kWidth + x)] == 0 ? 1 : 0;
    return count / static_cast<double>(kHeight * (to - from));
  };
  // Disparities 21.2 and 10.6 px: a shadow of 10.6 columns.
  EXPECT_GT(lost(150, 159), 0.99);
  EXPECT_EQ(lost(100, 146), 0.0);
  EXPECT_NEAR(lost(160, 161), 0.4, 5 * std::sqrt(0.24 / kHeight));
  EXPECT_NEAR(lost(220, 221), 0.4, 5 * std::sqrt(0.24 / kHeight));
  EXPECT_EQ(lost(222, 320), 0.0);
  EXPECT_EQ(lost(162, 218), 0.0);
}

}  // namespace
}  // namespace extperfc::simulate
