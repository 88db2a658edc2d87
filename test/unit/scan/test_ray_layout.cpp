// Which ray a direction belongs to, against std::atan2.
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/arc_tangent.hpp"
#include "extperfc/base/rng.hpp"

#include "scan/ray_layout.hpp"

namespace extperfc::scan {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

ScanParams layout(double angle_min, double angle_max, double increment) {
  ScanParams params;
  params.angle_min = angle_min;
  params.angle_max = angle_max;
  params.angle_increment = increment;
  return params;
}

TEST(ArcTangent, IsThatOfTheStandardLibrary) {
  double worst = 0;
  for (int i = -200'000; i <= 200'000; ++i) {
    const double angle = i * M_PI / 200'000;
    for (const double range : {1e-30, 1e-3, 1.0, 130.0, 1e30}) {
      const auto x = static_cast<float>(range * std::cos(angle));
      const auto y = static_cast<float>(range * std::sin(angle));
      worst = std::max(worst, std::abs(static_cast<double>(arc_tangent(y, x)) -
                                       std::atan2(static_cast<double>(y), static_cast<double>(x))));
    }
  }
  EXPECT_LT(worst, 6e-7) << "the header says so";
}

TEST(ArcTangent, OfAxesZerosAndWhatIsNoNumber) {
  EXPECT_EQ(arc_tangent(0, 0), 0.0F);
  EXPECT_EQ(arc_tangent(0, 2), 0.0F);
  EXPECT_FLOAT_EQ(arc_tangent(2, 0), static_cast<float>(M_PI / 2));
  EXPECT_FLOAT_EQ(arc_tangent(-2, 0), static_cast<float>(-M_PI / 2));
  EXPECT_FLOAT_EQ(arc_tangent(0, -2), static_cast<float>(M_PI));
  EXPECT_FLOAT_EQ(arc_tangent(3, kInf), 0.0F);
  EXPECT_TRUE(std::isnan(arc_tangent(kNaN, 1)));
  EXPECT_TRUE(std::isnan(arc_tangent(1, kNaN)));
}

/// By the definition: the bin whose middle is nearest, unless the direction is within `rounding` of an edge.
void expect_rays_of_the_definition(const ScanParams& params) {
  const RayLayout rays(params);
  Rng rng(7);
  std::vector<float> x;
  std::vector<float> y;
  for (int i = 0; i < 20'000; ++i) {
    x.push_back(static_cast<float>(rng.uniform(-10, 10)));
    y.push_back(static_cast<float>(rng.uniform(-10, 10)));
  }
  std::vector<std::uint32_t> found;
  rays.rays_of(x, y, found);
  ASSERT_EQ(found.size(), x.size());
  int compared = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    ASSERT_EQ(found[i], rays.ray_of(x[i], y[i])) << "one by one and many at once";
    const double angle = std::atan2(static_cast<double>(y[i]), static_cast<double>(x[i]));
    double from_edge = std::fmod(angle - params.angle_min + 0.5 * params.angle_increment, 2 * M_PI);
    if (from_edge < 0) from_edge += 2 * M_PI;
    const double bin = from_edge / params.angle_increment;
    constexpr double kRoundingRad = 3e-6;
    if (std::abs(bin - std::round(bin)) * params.angle_increment < kRoundingRad) continue;
    const auto expected = static_cast<std::size_t>(bin);
    EXPECT_EQ(found[i], std::min(expected, rays.count())) << x[i] << ", " << y[i];
    ++compared;
  }
  EXPECT_GT(compared, 15'000);
}

TEST(RayLayout, RaysStandInTheMiddleOfTheirBins) {
  expect_rays_of_the_definition(layout(-M_PI, M_PI, 2 * M_PI / 900));
  expect_rays_of_the_definition(layout(0, 2 * M_PI, 2 * M_PI / 360));
  expect_rays_of_the_definition(layout(-2 * M_PI, 0, 2 * M_PI / 360));
  expect_rays_of_the_definition(layout(-M_PI, M_PI, 1e-3));
}

TEST(RayLayout, APartOfATurnHasNoRaysElsewhere) {
  expect_rays_of_the_definition(layout(-M_PI / 2, M_PI / 2, M_PI / 180));
  expect_rays_of_the_definition(layout(3, 5, 0.01));
  expect_rays_of_the_definition(layout(-5, -3, 0.3));
  const RayLayout front(layout(-1, 1, 0.1));
  EXPECT_EQ(front.ray_of(-1, 0), front.count());
}

TEST(RayLayout, NoNumberHasNoRayOfItsOwn) {
  for (const auto& params : {layout(-M_PI, M_PI, 0.1), layout(-1, 1, 0.1)}) {
    const RayLayout rays(params);
    std::vector<std::uint32_t> found;
    rays.rays_of({kNaN, 1, kInf, kInf, -kInf}, {1, kNaN, kInf, 1, -kInf}, found);
    for (const std::uint32_t ray : found) EXPECT_LE(ray, rays.count());
  }
}

}  // namespace
}  // namespace extperfc::scan
