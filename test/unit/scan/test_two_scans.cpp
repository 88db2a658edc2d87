// The supported range for maps against the nearest for cost maps; beams without a return.
#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"

#include "test/unit/scan/vlp16.hpp"

namespace extperfc::scan {
namespace {

TestPoint at(double angle_deg, double range_m, std::uint16_t ring) {
  return {static_cast<float>(range_m * std::cos(angle_deg * kDegree)),
          static_cast<float>(range_m * std::sin(angle_deg * kDegree)), 0.5F, static_cast<float>(ring), ring};
}

float supported_at(const std::vector<TestPoint>& points, double angle_deg = 0,
                   const ScanParams& params = open_params()) {
  const auto scan = run_both(params, points).scans.supported;
  return scan.ranges[ray_at(scan, angle_deg * kDegree)];
}

TEST(TwoScans, ALoneSpeckleCountsForTheNearestOnly) {
  const std::vector<TestPoint> points{at(0, 2, 7), at(0, 5, 3), at(0, 5.06, 4), at(0, 5.1, 5)};
  const auto both = run_both(open_params(), points);
  const auto ray = ray_at(both.scans.nearest, 0);
  EXPECT_FLOAT_EQ(both.scans.nearest.ranges[ray], 2.0F);
  EXPECT_NEAR(both.scans.supported.ranges[ray], (5 + 5.06 + 5.1) / 3, 1e-5);
  EXPECT_EQ(both.statistics.rays_supported, 1U);
  EXPECT_EQ(both.scans.nearest.intensities[ray], 7.0F);
  EXPECT_EQ(both.scans.supported.intensities[ray], 3.0F) << "of its own nearest point";
}

TEST(TwoScans, TheNearestOfTwoSurfacesCounts) {
  EXPECT_NEAR(supported_at({at(0, 3, 1), at(0, 3.1, 2), at(0, 5, 3), at(0, 5, 4), at(0, 5, 5)}), 3.05, 1e-5);
}

TEST(TwoScans, RingsThatAreFarApartDoNotAgree) {
  EXPECT_TRUE(std::isnan(supported_at({at(0, 3, 1), at(0, 3.16, 2)})));
  EXPECT_NEAR(supported_at({at(0, 3, 1), at(0, 3.14, 2)}), 3.07, 1e-5);
  auto wide = open_params();
  wide.support_m = 0.3;
  EXPECT_NEAR(supported_at({at(0, 3, 1), at(0, 3.16, 2)}, 0, wide), 3.08, 1e-5);
}

TEST(TwoScans, NeighboursHelpWhereARayHasOneRing) {
  EXPECT_FLOAT_EQ(supported_at({at(0, 3, 1), at(1, 3.05, 2)}), 3.0F);
  EXPECT_TRUE(std::isnan(supported_at({at(0, 3, 1), at(2, 3.05, 2)}))) << "two rays away is too far";
  EXPECT_FLOAT_EQ(supported_at({at(180, 3, 1), at(-179, 3.05, 2)}, -180), 3.0F) << "a revolution has no end";
  auto half = open_params();
  half.angle_min = -90 * kDegree;
  half.angle_max = 90 * kDegree;
  EXPECT_TRUE(std::isnan(supported_at({at(-90, 3, 1), at(90, 3.05, 2)}, -90, half)))
      << "half a revolution has";
}

TEST(TwoScans, OneRingNeedsThreePoints) {
  EXPECT_TRUE(std::isnan(supported_at({at(0, 9, 7), at(1, 9, 7)})));
  EXPECT_FLOAT_EQ(supported_at({at(0, 9, 7), at(1, 9, 7), at(-1, 9.1, 7)}), 9.0F);
  EXPECT_FLOAT_EQ(supported_at({at(0, 4, 7), at(0.1, 4, 7), at(-0.1, 4, 7)}), 4.0F);
  const auto both = run_both(open_params(), {at(0, 4, 7), at(0.1, 4, 7), at(-0.1, 4, 7)});
  EXPECT_EQ(both.statistics.rays_supported, 0U);
}

/// A round wall at 2 m, `per_ray` points of it on each ray.
std::vector<TestPoint> round_wall(int per_ray, double noise_m) {
  Rng rng(1);
  std::vector<TestPoint> points;
  points.reserve(static_cast<std::size_t>(360 * per_ray));
  for (int degree = 0; degree < 360; ++degree)
    for (int i = 0; i < per_ray; ++i)
      points.push_back(at(degree, 2 + rng.normal(0, noise_m), static_cast<std::uint16_t>(i % 16)));
  return points;
}

double mean_nearest(const std::vector<TestPoint>& points, const ScanParams& params) {
  const auto ranges = run_both(params, points).scans.nearest.ranges;
  return std::accumulate(ranges.begin(), ranges.end(), 0.0) / static_cast<double>(ranges.size());
}

TEST(TwoScans, TheNearestOfManyNoisyPointsIsNotTooNear) {
  for (const double noise_m : {0.01, 0.02}) {
    auto params = open_params();
    for (const int per_ray : {1, 2, 3, 7, 12, 30, 60}) {
      SCOPED_TRACE(testing::Message() << per_ray << " points of " << noise_m << " m");
      const auto wall = round_wall(per_ray, noise_m);
      params.range_noise_m = 0;
      EXPECT_LE(mean_nearest(wall, params), 2 - (per_ray > 9 ? 1.5 : -0.2) * noise_m);
      params.range_noise_m = noise_m;
      EXPECT_NEAR(mean_nearest(wall, params), 2, 0.2 * noise_m);
    }
  }
}

TEST(TwoScans, APostBeforeAWallStaysWhereItIs) {
  auto params = open_params();
  params.range_noise_m = 0.01;
  std::vector<TestPoint> points = round_wall(30, 0.01);
  points.push_back(at(90, 1.9, 7));
  const auto scan = run_both(params, points).scans.nearest;
  EXPECT_FLOAT_EQ(scan.ranges[ray_at(scan, 90 * kDegree)], 1.9F);
}

TEST(TwoScans, NoRangeLeavesTheScansOwn) {
  auto params = open_params();
  params.range_noise_m = 0.05;
  params.range_max = 2;
  const auto ranges = run_both(params, round_wall(30, 0.001)).scans.nearest.ranges;
  EXPECT_LE(*std::max_element(ranges.begin(), ranges.end()), 2.0F);
}

TEST(TwoScans, TwoRingsGoBeforeThreePointsOfOne) {
  EXPECT_FLOAT_EQ(supported_at({at(0, 2, 7), at(0.1, 2, 7), at(-0.1, 2, 7), at(0, 5, 3), at(0, 5, 4)}), 5.0F);
}

TEST(TwoScans, WithoutARingFieldTheElevationSeparatesRings) {
  const auto with_z = [](double z) { return TestPoint{5, 0, static_cast<float>(z)}; };
  const auto nearest_at = [&](const std::vector<TestPoint>& points) {
    const CloudBuilder cloud(points);
    auto view = cloud.view();
    view.ring.reset();
    const auto scan = run_both(open_params(), view, {{0, Pose::Identity()}}).scans.supported;
    return scan.ranges[ray_at(scan, 0)];
  };
  EXPECT_FLOAT_EQ(nearest_at({with_z(0.1), with_z(0.1 + 5 * std::tan(2 * kDegree))}), 5.0F);
  EXPECT_TRUE(std::isnan(nearest_at({with_z(0.1), with_z(0.12)}))) << "0.23 degrees: one and the same ring";
}

/// Law: the supported range is never nearer than the nearest, and only rays that met something have one.
TEST(TwoScansProperty, SupportedIsNeverNearerThanNearest) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Rng rng(seed);
    auto params = open_params();
    params.angle_increment = rng.uniform(0.005, 0.05);
    params.range_max = 8;
    std::vector<TestPoint> points;
    for (int i = 0; i < 4000; ++i)
      points.push_back(
          at(rng.uniform(-180, 180), rng.uniform(1, 10), static_cast<std::uint16_t>(rng.integer(0, 15))));
    const auto [scans, statistics] = run_both(params, points);
    for (std::size_t i = 0; i < scans.nearest.ranges.size(); ++i) {
      const float nearest = scans.nearest.ranges[i];
      const float supported = scans.supported.ranges[i];
      ASSERT_EQ(std::isinf(nearest), std::isinf(supported) && !std::isfinite(nearest)) << seed << " " << i;
      if (std::isfinite(supported)) {
        ASSERT_LE(nearest, supported) << seed << " " << i;
      }
    }
    EXPECT_EQ(statistics.rays_met + statistics.rays_free + statistics.rays_unknown,
              scans.nearest.ranges.size());
    EXPECT_EQ(statistics.rays_met, hits(scans.nearest));
  }
}

/// Law: the order of points makes no difference.
TEST(TwoScansProperty, OrderDoesNotMatter) {
  Rng rng(11);
  std::vector<TestPoint> points;
  for (int i = 0; i < 3000; ++i)
    points.push_back(
        at(rng.uniform(-180, 180), rng.uniform(1, 10), static_cast<std::uint16_t>(rng.integer(0, 15))));
  auto params = open_params();
  params.intensity = IntensityOf::kNone;
  const auto first = run_both(params, points).scans;
  std::reverse(points.begin(), points.end());
  const auto again = run_both(params, points).scans;
  for (std::size_t i = 0; i < first.nearest.ranges.size(); ++i) {
    ASSERT_EQ(std::isnan(first.supported.ranges[i]), std::isnan(again.supported.ranges[i]));
    if (!std::isnan(first.supported.ranges[i])) {
      ASSERT_FLOAT_EQ(first.supported.ranges[i], again.supported.ranges[i]);
    }
    if (!std::isnan(first.nearest.ranges[i])) {
      ASSERT_EQ(first.nearest.ranges[i], again.nearest.ranges[i]);
    }
  }
}

/// An organised cloud of 3 rings (-2, 0, 2 degrees) and 360 firings; a wall at x = 5 m gives the returns.
std::vector<TestPoint> organised(bool rows_are_rings) {
  std::vector<TestPoint> points(3 * 360);
  for (std::uint16_t ring = 0; ring < 3; ++ring)
    for (std::size_t firing = 0; firing < 360; ++firing) {
      const double azimuth = static_cast<double>(firing) * kDegree - M_PI;
      const double elevation = (2.0 * ring - 2) * kDegree;
      const double range = std::cos(azimuth) > 0.3 ? 5 / std::cos(azimuth) : std::nan("");
      TestPoint& point = points[rows_are_rings ? ring * 360 + firing : firing * 3 + ring];
      point = {static_cast<float>(range * std::cos(azimuth)), static_cast<float>(range * std::sin(azimuth)),
               static_cast<float>(range * std::tan(elevation)), 0, ring};
      if (ring == 0 && std::abs(azimuth) > 90.5 * kDegree)  // tells the azimuth of the others
        point = {static_cast<float>(3 * std::cos(azimuth)), static_cast<float>(3 * std::sin(azimuth)),
                 static_cast<float>(3 * std::tan(elevation)), 0, ring};
    }
  return points;
}

TEST(SilentBeams, AreFreeOnlyWhereAskedFor) {
  for (const bool rows_are_rings : {true, false}) {
    const CloudBuilder cloud(organised(rows_are_rings));
    auto view = cloud.view();
    view.width = rows_are_rings ? 360 : 3;
    view.height = rows_are_rings ? 3 : 360;
    view.row_step = view.width * view.point_step;
    auto params = open_params();
    params.range_min = 4;  // the helpers' own returns do not count
    params.range_max = 20;
    params.min_height = -0.5;
    params.max_height = 0.8;
    const auto asked = [&](double no_return_range) {
      params.no_return_range = no_return_range;
      return run_both(params, view, {{0, Pose::Identity()}}).statistics.rays_free;
    };
    EXPECT_EQ(asked(0), 0U);
    EXPECT_EQ(asked(19), 0U) << "proves less than the scan's range";
    // Behind: the level ring stays in the band for 20 m and more, the others leave it (0.70 m at 2 degrees
    // stays, -0.70 m does not).
    EXPECT_EQ(asked(30), 179U);
  }
}

}  // namespace
}  // namespace extperfc::scan
