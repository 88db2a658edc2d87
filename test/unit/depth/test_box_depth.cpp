#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/depth/box_depth.hpp"

#include "test/unit/depth/depth_image.hpp"

namespace extperfc::depth {
namespace {

constexpr std::array<Estimator, 4> kAll{Estimator::kMean, Estimator::kMedian, Estimator::kTrimmedMean,
                                        Estimator::kNearestMode};
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

BoxDepthParams with(Estimator estimator) {
  BoxDepthParams params;
  params.estimator = estimator;
  return params;
}

/// A box of 60 x 60 pixels around the middle of an image of 100 x 80.
constexpr Box2 kBox{20, 10, 80, 70};

DepthImage flat(double depth_m, PixelFormat format = PixelFormat::kDepth16Mm) {
  return DepthImage(100, 80, format).fill([=](int, int) { return depth_m; });
}

TEST(BoxDepth, FlatSurfaceIsExactForEveryEstimatorAndFormat) {
  for (const auto format : {PixelFormat::kDepth16Mm, PixelFormat::kDepth32M}) {
    const auto image = flat(1.25, format);
    for (const auto estimator : kAll) {
      const auto found = estimate_depth(image.view(), kBox, with(estimator));
      ASSERT_TRUE(found) << to_string(estimator);
      EXPECT_NEAR(found->depth_m, 1.25, 1e-6) << to_string(estimator);
      EXPECT_DOUBLE_EQ(found->valid_fraction, 1.0);
      EXPECT_GT(found->sigma_m, 0.0);
    }
  }
}

TEST(BoxDepth, MeanIsThePapersFormulaOverTheCentralWindow) {
  DepthImage image(100, 80);
  image.fill([](int x, int y) { return 0.5 + 0.001 * (7 * x + 3 * y) + 0.001 * ((x * y) % 11); });
  double sum_m = 0.0;
  int valid = 0;
  for (int y = 30; y < 50; ++y) {
    for (int x = 40; x < 60; ++x) {
      if ((x + y) % 3 == 0) {
        image.set(x, y, 0.0);
        continue;
      }
      sum_m += 0.5 + 0.001 * (7 * x + 3 * y) + 0.001 * ((x * y) % 11);
      ++valid;
    }
  }
  const auto found = estimate_depth(image.view(), kBox, with(Estimator::kMean));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->valid_px, valid);
  EXPECT_NEAR(found->depth_m, sum_m / valid, 1e-6);
  EXPECT_NEAR(found->valid_fraction, valid / 400.0, 1e-12);
}

TEST(BoxDepth, MedianAndTrimmedMeanOfKnownValues) {
  DepthImage image(10, 1, PixelFormat::kDepth32M);
  image.fill([](int x, int) { return x == 9 ? 9.5 : 1.0 + x; });  // 1, 2, ... 9, 9.5
  const Box2 all{0, 0, 10, 1};
  EXPECT_NEAR(estimate_depth(image.view(), all, with(Estimator::kMedian))->depth_m, 5.5, 1e-6);
  EXPECT_NEAR(estimate_depth(image.view(), all, with(Estimator::kTrimmedMean))->depth_m, 5.5, 1e-6);
  image.set(0, 0, 0.0);
  EXPECT_NEAR(estimate_depth(image.view(), all, with(Estimator::kMedian))->depth_m, 6.0, 1e-6);
}

TEST(BoxDepth, NearestModePrefersTheObjectToTheLargerBackground) {
  DepthImage image(100, 80);
  image.fill([](int x, int) { return x >= 44 && x < 52 ? 1.0 : 1.6; });  // a third of the central 24 px
  EXPECT_NEAR(estimate_depth(image.view(), kBox, with(Estimator::kNearestMode))->depth_m, 1.0, 0.005);
  EXPECT_GT(estimate_depth(image.view(), kBox, with(Estimator::kMean))->depth_m, 1.3);
}

TEST(BoxDepth, NearestModeIgnoresAFewFlyingPixels) {
  auto image = flat(1.0);
  for (int i = 0; i < 15; ++i) image.set(40 + i, 35, 0.4);
  EXPECT_NEAR(estimate_depth(image.view(), kBox, with(Estimator::kNearestMode))->depth_m, 1.0, 0.002);
}

TEST(BoxDepth, NearestModeIsExactOnSlantedPlanes) {
  Rng rng(3);
  for (int i = 0; i < 200; ++i) {
    const double q = 1.0 / rng.uniform(0.3, 3.0);
    const double a = rng.uniform(-0.003, 0.003) * q;  // inverse depth is affine on a plane
    const double b = rng.uniform(-0.003, 0.003) * q;
    DepthImage image(100, 80, PixelFormat::kDepth32M);
    image.fill([&](int x, int y) { return 1.0 / (q + a * (x + 0.5 - 50.0) + b * (y + 0.5 - 40.0)); });
    const auto found = estimate_depth(image.view(), kBox, with(Estimator::kNearestMode));
    ASSERT_TRUE(found) << "seed 3, case " << i;
    EXPECT_NEAR(found->depth_m * q, 1.0, 5e-3) << "seed 3, case " << i;
  }
}

TEST(BoxDepth, NearestModeLooksAtTheWholeBoxWhenItsMiddleIsAHole) {
  auto image = flat(1.0);
  for (int y = 20; y < 60; ++y)
    for (int x = 30; x < 70; ++x) image.set(x, y, 0.0);
  const auto found = estimate_depth(image.view(), kBox, with(Estimator::kNearestMode));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->depth_m, 1.0, 1e-6);
  EXPECT_LT(found->valid_fraction, 0.7);
}

TEST(BoxDepth, OnlyFiniteValuesInRangeAreValid) {
  for (const auto estimator : kAll) {
    for (const double junk : {0.0, -1.0, kNaN, kInf, -kInf, 0.05, 12.0}) {
      DepthImage image(100, 80, PixelFormat::kDepth32M);
      image.fill([=](int x, int) { return x % 2 == 0 ? junk : 2.0; });
      const auto found = estimate_depth(image.view(), kBox, with(estimator));
      ASSERT_TRUE(found) << to_string(estimator) << " " << junk;
      EXPECT_NEAR(found->depth_m, 2.0, 1e-5) << to_string(estimator) << " " << junk;
      EXPECT_NEAR(found->valid_fraction, 0.5, 0.05);
      EXPECT_FALSE(estimate_depth(flat(junk, PixelFormat::kDepth32M).view(), kBox, with(estimator)));
    }
  }
}

TEST(BoxDepth, TooFewValidPixelsGiveNothing) {
  for (const auto estimator : kAll) {
    DepthImage image(100, 80);
    for (int x = 48; x < 52; ++x) image.set(x, 40, 1.0);
    EXPECT_FALSE(estimate_depth(image.view(), kBox, with(estimator)));
    image.set(52, 40, 1.0);
    EXPECT_TRUE(estimate_depth(image.view(), kBox, with(estimator)));
  }
}

TEST(BoxDepth, BoxesThatCannotBeGiveNothing) {
  constexpr auto kNanF = std::numeric_limits<float>::quiet_NaN();
  constexpr auto kInfF = std::numeric_limits<float>::infinity();
  const auto image = flat(1.0);
  const std::array<Box2, 10> boxes{{{kNanF, 0, 10, 10},
                                    {0, 0, 10, kNanF},
                                    {-kInfF, 0, kInfF, 10},
                                    {0, 0, 0, 0},
                                    {50, 10, 40, 70},
                                    {20, 70, 80, 10},
                                    {-30, 0, 0, 40},
                                    {100, 0, 140, 40},
                                    {0, 80, 50, 90},
                                    {1e30F, 0, 2e30F, 40}}};
  for (const auto estimator : kAll)
    for (const auto& box : boxes)
      EXPECT_FALSE(estimate_depth(image.view(), box, with(estimator))) << box.x_min;
}

TEST(BoxDepth, BoxesAreClippedToTheImage) {
  const auto image = flat(1.0);
  for (const auto estimator : kAll)
    for (const Box2& box :
         {Box2{-30, -30, 20, 20}, Box2{80, 60, 1000, 1000}, Box2{-1e30F, -1e30F, 1e30F, 1e30F}})
      EXPECT_NEAR(estimate_depth(image.view(), box, with(estimator))->depth_m, 1.0, 1e-6);
}

TEST(BoxDepth, BoxOfOnePixel) {
  const auto image = flat(1.0);
  auto params = with(Estimator::kNearestMode);
  const Box2 pixel{50, 40, 51, 41};
  EXPECT_FALSE(estimate_depth(image.view(), pixel, params));  // one value is less than min_valid_px
  params.min_valid_px = 1;
  EXPECT_NEAR(estimate_depth(image.view(), pixel, params)->depth_m, 1.0, 1e-6);
  params.estimator = Estimator::kMean;
  params.window_px = 1;
  EXPECT_EQ(estimate_depth(image.view(), pixel, params)->valid_px, 1);
}

TEST(BoxDepth, WindowOfOnePixelIsTheCentrePixel) {
  DepthImage image(9, 9);
  image.fill([](int x, int y) { return 1.0 + 0.1 * x + 0.01 * y; });
  auto params = with(Estimator::kMedian);
  params.window_px = 1;
  params.min_valid_px = 1;
  EXPECT_NEAR(estimate_depth(image.view(), {2, 3, 5, 6}, params)->depth_m, 1.34, 1e-6);
}

TEST(BoxDepth, RowPaddingAndOddAddressesChangeNothing) {
  const auto depth = [](int x, int y) { return 1.0 + 0.002 * x + 0.001 * y; };
  for (const auto format : {PixelFormat::kDepth16Mm, PixelFormat::kDepth32M}) {
    for (const auto estimator : kAll) {
      const auto plain = DepthImage(100, 80, format).fill(depth);
      const auto odd = DepthImage(100, 80, format, 7, 1).fill(depth);
      const auto a = estimate_depth(plain.view(), kBox, with(estimator));
      const auto b = estimate_depth(odd.view(), kBox, with(estimator));
      ASSERT_TRUE(a && b);
      EXPECT_DOUBLE_EQ(a->depth_m, b->depth_m);
    }
  }
}

TEST(BoxDepth, ImagesThatAreNoDepthGiveNothing) {
  const auto image = flat(1.0);
  ImageView color = image.view();
  color.format = PixelFormat::kMono16;
  EXPECT_FALSE(estimate_depth(color, kBox, {}));
  ImageView short_rows = image.view();
  short_rows.row_bytes = 199;
  EXPECT_FALSE(estimate_depth(short_rows, kBox, {}));
  EXPECT_FALSE(estimate_depth(ImageView{}, kBox, {}));
}

TEST(BoxDepth, LargeRegionsAreSampled) {
  DepthImage image(1280, 720);
  image.fill([](int, int) { return 2.0; });
  const Box2 all{0, 0, 1280, 720};
  for (const auto estimator : kAll) {
    auto params = with(estimator);
    params.window_px = 1000;
    params.central_fraction = 1.0;
    const auto found = estimate_depth(image.view(), all, params);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->depth_m, 2.0, 1e-6);
    EXPECT_GT(found->valid_px, 500);
  }
}

TEST(BoxDepth, AnyImageAndAnyBoxIsDefined) {
  Rng rng(11);
  for (int i = 0; i < 3000; ++i) {
    const auto format = rng.chance(0.5) ? PixelFormat::kDepth16Mm : PixelFormat::kDepth32M;
    DepthImage image(rng.integer(1, 40), rng.integer(1, 40), format, 1, 1);
    image.fill([&](int, int) { return rng.chance(0.3) ? 0.0 : rng.uniform(0.0, 15.0); });
    const auto edge = [&] { return static_cast<float>(rng.uniform(-20.0, 60.0)); };
    auto params = with(kAll[static_cast<std::size_t>(rng.integer(0, 3))]);
    params.min_valid_px = 1;
    params.window_px = rng.integer(1, 60);
    params.central_fraction = rng.uniform(0.01, 1.0);
    const auto found = estimate_depth(image.view(), {edge(), edge(), edge(), edge()}, params);
    if (!found) continue;
    EXPECT_GE(found->depth_m, 0.99 * params.min_depth_m) << "seed 11, case " << i;
    EXPECT_LE(found->depth_m, 1.01 * params.max_depth_m) << "seed 11, case " << i;
    EXPECT_TRUE(std::isfinite(found->sigma_m) && found->sigma_m > 0.0) << "seed 11, case " << i;
    EXPECT_TRUE(found->valid_fraction > 0.0 && found->valid_fraction <= 1.0) << "seed 11, case " << i;
  }
}

TEST(BoxDepthParams, EstimatorNamesGoBothWays) {
  for (const auto estimator : kAll) EXPECT_EQ(*estimator_from_name(to_string(estimator)), estimator);
  const auto unknown = estimator_from_name("average");
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("average"), std::string::npos);
}

TEST(BoxDepthParams, ValidateNamesTheFirstBadParameter) {
  EXPECT_TRUE(validate(BoxDepthParams{}));
  const auto names = [](const char* name, auto change) {
    BoxDepthParams params;
    change(params);
    const auto result = validate(params);
    ASSERT_FALSE(result) << name;
    EXPECT_NE(result.error().message.find(name), std::string::npos) << result.error().message;
  };
  names("window_px", [](auto& p) { p.window_px = 0; });
  names("window_px", [](auto& p) { p.window_px = 1001; });
  names("central_fraction", [](auto& p) { p.central_fraction = kNaN; });
  names("min_depth_m", [](auto& p) { p.min_depth_m = 0.0; });
  names("max_depth_m", [](auto& p) { p.max_depth_m = 0.05; });
  names("max_depth_m", [](auto& p) { p.max_depth_m = kInf; });
  names("min_valid_px", [](auto& p) { p.min_valid_px = 0; });
  names("baseline_m", [](auto& p) { p.noise.baseline_m = -0.05; });
  names("correlation_px", [](auto& p) { p.noise.correlation_px = 0.0; });
  names("common_fraction", [](auto& p) { p.noise.common_fraction = 1.5; });
}

}  // namespace
}  // namespace extperfc::depth
