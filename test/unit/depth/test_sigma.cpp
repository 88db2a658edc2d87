// Is sigma_m the size of the error that really occurs?

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/depth/box_depth.hpp"

#include "test/unit/depth/depth_image.hpp"

namespace extperfc::depth {
namespace {

constexpr int kTrials = 400;       // where the closed form is compared
constexpr int kRoughTrials = 120;  // where a factor is
constexpr Box2 kBox{10, 10, 70, 70};
constexpr double kDepth = 1.5;

struct Calibration {
  double rms_error_m{0};
  double mean_sigma_m{0};
};

/// A wall at kDepth whose inverse depth carries noise that is constant in cells of `cell` x `cell` pixels,
/// the model of StereoNoiseModel::variance_left(); cells lie anew in each trial.
Calibration calibrate(const BoxDepthParams& params, int cell, int trials, Rng& rng) {
  Calibration result;
  DepthImage image(80, 80, PixelFormat::kDepth32M);
  std::array<std::array<double, 81>, 81> cells{};
  for (int trial = 0; trial < trials; ++trial) {
    for (auto& row : cells)
      for (auto& q : row) q = 1.0 / kDepth + rng.normal(0.0, params.noise.sigma_inverse_depth());
    const int shift_x = rng.integer(0, cell - 1);
    const int shift_y = rng.integer(0, cell - 1);
    image.fill([&](int x, int y) {
      return 1.0 / cells[static_cast<std::size_t>((y + shift_y) / cell)]
                        [static_cast<std::size_t>((x + shift_x) / cell)];
    });
    const auto found = estimate_depth(image.view(), kBox, params);
    if (!found) continue;
    result.rms_error_m += std::pow(found->depth_m - kDepth, 2) / trials;
    result.mean_sigma_m += found->sigma_m / trials;
  }
  result.rms_error_m = std::sqrt(result.rms_error_m);
  return result;
}

BoxDepthParams params_for(Estimator estimator, int cell) {
  BoxDepthParams params;
  params.estimator = estimator;
  params.noise.correlation_px = cell;
  params.noise.common_fraction = 0.0;
  return params;
}

TEST(Sigma, MeanOfIndependentPixelsIsTheClosedForm) {
  Rng rng(1);
  const auto params = params_for(Estimator::kMean, 1);
  const auto c = calibrate(params, 1, kTrials, rng);
  const double expected_m = params.noise.sigma(kDepth) / 20.0;  // s / sqrt(n), n = 20 x 20
  EXPECT_NEAR(c.mean_sigma_m, expected_m, 0.1 * expected_m);
  // The RMS of N trials has a relative standard deviation of 1 / sqrt(2 N) = 3.5 %; four of them.
  EXPECT_NEAR(c.rms_error_m, expected_m, 0.14 * expected_m);
}

TEST(Sigma, MedianOfIndependentPixelsIsTheClosedForm) {
  Rng rng(2);
  const auto params = params_for(Estimator::kMedian, 1);
  const auto c = calibrate(params, 1, kTrials, rng);
  const double expected_m = params.noise.sigma(kDepth) / 20.0 * std::sqrt(std::acos(-1.0) / 2.0);
  EXPECT_NEAR(c.mean_sigma_m, expected_m, 0.1 * expected_m);
  EXPECT_NEAR(c.rms_error_m, expected_m, 0.14 * expected_m);
}

TEST(Sigma, EveryEstimatorIsCalibratedUnderCorrelatedNoise) {
  for (const auto estimator :
       {Estimator::kMean, Estimator::kMedian, Estimator::kTrimmedMean, Estimator::kNearestMode}) {
    for (const int cell : {1, 4, 7}) {
      Rng rng(3);
      const auto c = calibrate(params_for(estimator, cell), cell, kRoughTrials, rng);
      EXPECT_GT(c.mean_sigma_m / c.rms_error_m, 0.6) << to_string(estimator) << ", cells of " << cell;
      EXPECT_LT(c.mean_sigma_m / c.rms_error_m, 1.8) << to_string(estimator) << ", cells of " << cell;
    }
  }
}

TEST(Sigma, CommonErrorIsNotAveragedAway) {
  const StereoNoiseModel noise;
  EXPECT_DOUBLE_EQ(noise.variance_left(1.0), 1.0);
  EXPECT_NEAR(noise.variance_left(1e12), noise.common_fraction, 1e-6);
  for (double pixels = 1.0; pixels < 1e6; pixels *= 2.0)
    EXPECT_GE(noise.variance_left(pixels), noise.variance_left(2.0 * pixels));
}

TEST(Sigma, MixedWindowIsLessCertainThanACleanOne) {
  const auto clean = DepthImage(80, 80).fill([](int, int) { return kDepth; });
  const auto mixed = DepthImage(80, 80).fill([](int x, int) { return x < 42 ? kDepth : 3.0; });
  const auto params = params_for(Estimator::kMean, 7);
  EXPECT_GT(estimate_depth(mixed.view(), kBox, params)->sigma_m,
            5.0 * estimate_depth(clean.view(), kBox, params)->sigma_m);
}

TEST(Sigma, SlantMakesTheDepthDependOnTheBox) {
  const auto flat = DepthImage(80, 80).fill([](int, int) { return kDepth; });
  const auto slanted = DepthImage(80, 80).fill([](int x, int) { return kDepth + 0.01 * (x - 40); });
  const auto params = params_for(Estimator::kNearestMode, 7);
  EXPECT_GT(estimate_depth(slanted.view(), kBox, params)->sigma_m,
            1.5 * estimate_depth(flat.view(), kBox, params)->sigma_m);
}

}  // namespace
}  // namespace extperfc::depth
