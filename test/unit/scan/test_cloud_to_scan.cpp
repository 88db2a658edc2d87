// Ranges, bins, limits: against closed forms and against a plain search over all points.
#include <limits>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"

#include "test/unit/scan/cloud_builder.hpp"

namespace extperfc::scan {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

TestPoint at(double angle_deg, double range_m, double z_m = 0.5) {
  return {static_cast<float>(range_m * std::cos(angle_deg * kDegree)),
          static_cast<float>(range_m * std::sin(angle_deg * kDegree)), static_cast<float>(z_m)};
}

TEST(CloudToScan, WallAtThreeMetres) {
  std::vector<TestPoint> wall;
  for (int y = -1000; y <= 1000; ++y)
    for (const float z : {0.2F, 0.6F}) wall.push_back({3.0F, 0.005F * static_cast<float>(y), z});
  const auto [scan, statistics] = run(open_params(), wall);
  EXPECT_EQ(statistics.points, wall.size());
  EXPECT_EQ(statistics.used, wall.size());
  for (int degree = -58; degree <= 58; ++degree) {
    const double nearest_edge =
        std::max(0.0, std::abs(degree) - 0.5) * kDegree;  // of the bin, to the wall's foot
    const float range = scan.ranges[ray_at(scan, degree * kDegree)];
    EXPECT_NEAR(range, 3.0 / std::cos(nearest_edge), 0.01) << degree;
  }
  EXPECT_TRUE(std::isnan(scan.ranges[ray_at(scan, 90 * kDegree)])) << "no beam there";
}

TEST(CloudToScan, FullTurnHasNoRayTwice) {
  const auto [scan, statistics] = run(open_params(), CloudView{});
  EXPECT_EQ(scan.ranges.size(), 360U);
  EXPECT_DOUBLE_EQ(scan.angle_min, -M_PI);
  EXPECT_NEAR(scan.angle_max, M_PI - kDegree, 1e-9) << "the angle of the last ray";
}

TEST(CloudToScan, PartOfATurnIncludesBothEnds) {
  auto params = open_params();
  params.angle_min = -45 * kDegree;
  params.angle_max = 45 * kDegree;
  const auto [scan, statistics] =
      run(params, {at(-45, 2), at(45, 3), at(45.4, 2.5), at(45.6, 1), at(-45.6, 1)});
  ASSERT_EQ(scan.ranges.size(), 91U);
  EXPECT_NEAR(scan.angle_max, params.angle_max, 1e-9);
  EXPECT_FLOAT_EQ(scan.ranges.front(), 2.0F);
  EXPECT_FLOAT_EQ(scan.ranges.back(), 2.5F);
  EXPECT_EQ(statistics.used, 3U);
}

TEST(CloudToScan, ARayStandsInTheMiddleOfItsBin) {
  for (const double degree : {-180.0, -179.0, -90.0, -1.0, 0.0, 1.0, 90.0, 179.0}) {
    const auto inside = run(open_params(), {at(degree - 0.49, 5), at(degree + 0.49, 6)});
    EXPECT_FLOAT_EQ(inside.scan.ranges[ray_at(inside.scan, degree * kDegree)], 5.0F) << degree;
    EXPECT_EQ(hits(inside.scan), 1U) << degree;
    const auto beside = run(open_params(), {at(degree - 0.51, 5), at(degree + 0.51, 6)});
    EXPECT_TRUE(std::isnan(beside.scan.ranges[ray_at(beside.scan, degree * kDegree)])) << degree;
    EXPECT_EQ(hits(beside.scan), 2U) << degree;
  }
}

TEST(CloudToScan, AnglesMayBeginAnywhere) {
  auto params = open_params();
  params.angle_min = 0;
  params.angle_max = 2 * M_PI;
  const auto [scan, statistics] = run(params, {at(-90, 4), at(359.8, 2), at(0.2, 3)});
  ASSERT_EQ(scan.ranges.size(), 360U);
  EXPECT_FLOAT_EQ(scan.ranges[270], 4.0F);
  EXPECT_FLOAT_EQ(scan.ranges[0], 2.0F);
  EXPECT_EQ(hits(scan), 2U);
}

TEST(CloudToScan, HeightBandIsInclusive) {
  auto params = open_params();
  params.min_height = 0.25;
  params.max_height = 1.5;
  const auto [scan, statistics] =
      run(params, {at(0, 3, 0.25), at(10, 3, 1.5), at(20, 3, 0.2499), at(30, 3, 1.5001)});
  EXPECT_EQ(statistics.used, 2U);
  EXPECT_FLOAT_EQ(scan.ranges[ray_at(scan, 0)], 3.0F);
  EXPECT_FLOAT_EQ(scan.ranges[ray_at(scan, 10 * kDegree)], 3.0F);
}

TEST(CloudToScan, RangeLimitsAreInclusive) {
  auto params = open_params();
  params.range_min = 1;
  params.range_max = 8;
  const auto [scan, statistics] =
      run(params, {at(0, 1), at(90, 8), at(10, 0.999), at(20, 8.001), at(180, 4)});
  EXPECT_EQ(statistics.used, 3U);
  EXPECT_EQ(hits(scan), 3U);
}

TEST(CloudToScan, FreeIsOnlyWhereABeamWentOn) {
  auto params = open_params();
  params.range_min = 0.5;
  params.range_max = 8;
  params.min_height = -0.2;
  params.max_height = 0.6;
  const std::vector<TestPoint> points{
      at(0, 7, 0.1),      at(20, 9, 0.1),  // ends in the air, beyond range_max
      at(40, 16, 1.1),                     // 0.55 m high at range_max
      at(60, 16, 1.3),                     // 0.65 m: above the band there
      at(80, 16, -0.5),                    // -0.25 m: below it
      at(100, 7.99, 0.1), at(20, 3, 5)};   // points above do not count
  for (const bool use_inf : {true, false}) {
    params.use_inf = use_inf;
    params.inf_epsilon = 0.5;
    const float free = use_inf ? kInf : 8.5F;
    const auto both = run_both(params, points);
    const auto& scan = both.scans.nearest;
    EXPECT_FLOAT_EQ(scan.ranges[ray_at(scan, 0)], 7.0F);
    for (const int degree : {20, 40}) EXPECT_EQ(scan.ranges[ray_at(scan, degree * kDegree)], free) << degree;
    for (const int degree : {60, 80, 120})
      EXPECT_TRUE(std::isnan(scan.ranges[ray_at(scan, degree * kDegree)])) << degree;
    EXPECT_EQ(std::count(scan.ranges.begin(), scan.ranges.end(), free), 2);
    EXPECT_EQ(both.statistics.rays_free, 2U);
    EXPECT_EQ(both.statistics.rays_met, 2U);
    EXPECT_EQ(both.statistics.rays_unknown, 360U - 4U);
    EXPECT_EQ(both.scans.supported.ranges[ray_at(scan, 20 * kDegree)], free);
  }
}

TEST(CloudToScan, ABeamIsFollowedFromTheSensorNotFromTheOrigin) {
  auto params = open_params();
  params.range_max = 8;
  // The sensor stands 1 m to the left: its beam straight ahead meets the circle at asin(1 / 8).
  const auto [scan, statistics] = run(params, {{20, 0, 0}}, make_pose({0, 1, 0}));
  EXPECT_EQ(statistics.rays_free, 1U);
  EXPECT_EQ(scan.ranges[ray_at(scan, std::asin(1.0 / 8))], kInf);
}

TEST(CloudToScan, PointsThatAreNoNumbersDoNotCount) {
  std::vector<TestPoint> points{at(0, 3)};
  for (const float bad : {kNan, kInf, -kInf}) {
    points.push_back({bad, 1, 0.5F});
    points.push_back({1, bad, 0.5F});
    points.push_back({1, 1, bad});
    points.push_back({bad, bad, bad});
  }
  for (const auto method :
       {GroundMethod::kNone, GroundMethod::kHeight, GroundMethod::kPlane, GroundMethod::kSlope}) {
    auto params = open_params();
    params.ground.method = method;
    const auto [scan, statistics] = run(params, points);
    EXPECT_EQ(statistics.points, points.size());
    EXPECT_EQ(statistics.used, 1U) << to_string(method);
    EXPECT_EQ(hits(scan), 1U) << to_string(method);
  }
}

TEST(CloudToScan, AnEmptyCloudMeetsNothing) {
  for (const auto method :
       {GroundMethod::kNone, GroundMethod::kHeight, GroundMethod::kPlane, GroundMethod::kSlope}) {
    auto params = open_params();
    params.ground.method = method;
    const auto [scan, statistics] = run(params, CloudView{});
    EXPECT_EQ(scan.ranges.size(), 360U);
    EXPECT_EQ(hits(scan), 0U);
    EXPECT_EQ(statistics.points, 0U);
  }
}

TEST(CloudToScan, IntensityOfTheNearestOrTheLargest) {
  std::vector<TestPoint> points{at(0, 5), at(0, 3), at(0, 4)};
  points[0].intensity = 90;
  points[1].intensity = 20;
  points[2].intensity = 30;
  auto params = open_params();
  const auto nearest = run(params, points).scan;
  EXPECT_EQ(nearest.intensities[ray_at(nearest, 0)], 20.0F);
  EXPECT_EQ(nearest.intensities[0], 0.0F);
  params.intensity = IntensityOf::kMaximum;
  const auto largest = run(params, points).scan;
  EXPECT_EQ(largest.intensities[ray_at(largest, 0)], 90.0F);
  EXPECT_EQ(largest.ranges[ray_at(largest, 0)], 3.0F);
  params.intensity = IntensityOf::kNone;
  EXPECT_TRUE(run(params, points).scan.intensities.empty());
}

TEST(CloudToScan, HeightOfTheNearestInPlaceOfAnIntensity) {
  std::vector<TestPoint> points{at(0, 5), at(0, 3), at(90, 4), at(90, 4.05F), at(90, 4.05F)};
  points[0].z = 0.3F;
  points[1].z = 0.8F;
  points[2].z = 1.2F;
  points[3].z = 0.5F;
  points[4].z = 0.9F;
  auto params = open_params();
  params.intensity = IntensityOf::kHeight;
  const auto [scan, statistics] = run(params, points);
  EXPECT_FLOAT_EQ(scan.intensities[ray_at(scan, 0)], 0.8F);
  EXPECT_FLOAT_EQ(scan.intensities[ray_at(scan, 90 * kDegree)], 0.5F);
  EXPECT_EQ(scan.intensities[0], 0.0F);
  EXPECT_FALSE(statistics.intensity_missing);
}

TEST(CloudToScan, OnlySelectedRings) {
  std::vector<TestPoint> points;
  for (std::uint16_t ring = 0; ring < 16; ++ring) {
    points.push_back(at(ring, 3));
    points.back().ring = ring;
  }
  points.push_back(at(90, 3));
  points.back().ring = 65535;
  auto params = open_params();
  params.rings = *parse_rings("2,7-9");
  ASSERT_TRUE(params.rings);
  const auto [scan, statistics] = run(params, points);
  EXPECT_EQ(statistics.points, 17U);
  EXPECT_EQ(statistics.used, 4U);
  for (const int ring : {2, 7, 8, 9})
    EXPECT_FLOAT_EQ(scan.ranges[ray_at(scan, ring * kDegree)], 3.0F) << ring;
}

TEST(CloudToScan, HeightsAndRangesAreThoseOfTheTargetFrame) {
  auto params = open_params();
  params.min_height = 0.4;
  params.max_height = 0.6;
  // A sensor 1 m above the floor, 0.2 m ahead, turned by 90 degrees.
  const Pose target_T_cloud = make_pose({0.2, 0, 1.0}, {0, 0, M_PI / 2});
  const auto [scan, statistics] = run(params, {{0, -2.8F, -0.5F}, {0, -1.0F, 0.5F}}, target_T_cloud);
  EXPECT_EQ(statistics.used, 1U);
  EXPECT_NEAR(scan.ranges[ray_at(scan, 0)], 3.0F, 1e-5);
}

TEST(CloudToScan, MemoryOfOneCloudDoesNotReachTheNext) {
  auto converter = CloudToScan::make(open_params());
  ASSERT_TRUE(converter);
  PlanarScans scans;
  const CloudBuilder many({at(0, 3), at(10, 3), at(20, 3)});
  const CloudBuilder one({at(40, 2)});
  ASSERT_TRUE(converter->convert(many.view(), {{0, Pose::Identity()}}, {}, scans));
  const auto statistics = converter->convert(one.view(), {{0, Pose::Identity()}}, {}, scans);
  ASSERT_TRUE(statistics);
  EXPECT_EQ(statistics->used, 1U);
  EXPECT_EQ(hits(scans.nearest), 1U);
  EXPECT_EQ(hits(scans.supported), 0U);
  EXPECT_FLOAT_EQ(scans.nearest.ranges[ray_at(scans.nearest, 40 * kDegree)], 2.0F);
}

/// A random point that is not within rounding of a limit, so that both sides must decide alike.
TestPoint clear_point(Rng& rng, const ScanParams& params) {
  for (;;) {
    const TestPoint point{static_cast<float>(rng.uniform(-12, 12)), static_cast<float>(rng.uniform(-12, 12)),
                          static_cast<float>(rng.uniform(-0.5, 2.0)),
                          static_cast<float>(rng.uniform(0, 255))};
    const double bins = (std::atan2(point.y, point.x) - params.angle_min) / params.angle_increment + 0.5;
    const double range = std::hypot(point.x, point.y);
    const auto clear = [](double a, double b) { return std::abs(a - b) > 1e-4; };
    if (clear(bins, std::round(bins)) && clear(range, params.range_min) && clear(range, params.range_max) &&
        clear(point.z, params.min_height) && clear(point.z, params.max_height))
      return point;
  }
}

TEST(CloudToScanProperty, EveryRangeIsTheMinimumOfItsBin) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Rng rng(seed);
    auto params = open_params();
    params.min_height = 0.1;
    params.max_height = 1.4;
    params.range_min = 0.5;
    params.range_max = 10;
    params.angle_increment = rng.uniform(0.003, 0.05);
    params.angle_min = rng.uniform(-3.1, 0.5);
    params.angle_max = rng.uniform(params.angle_min, 3.1);
    std::vector<TestPoint> points(3000);
    for (auto& point : points) point = clear_point(rng, params);
    const auto scan = run(params, points).scan;
    std::vector<double> expected(scan.ranges.size(), std::numeric_limits<double>::infinity());
    for (const auto& p : points) {
      const double range = std::hypot(p.x, p.y);
      const double bin = std::floor((std::atan2(p.y, p.x) - params.angle_min) / params.angle_increment + 0.5);
      if (p.z < params.min_height || p.z > params.max_height || range < params.range_min ||
          range > params.range_max || bin < 0 || bin >= static_cast<double>(expected.size()))
        continue;
      double& smallest = expected[static_cast<std::size_t>(bin)];
      smallest = std::min(smallest, range);
    }
    for (std::size_t i = 0; i < expected.size(); ++i)
      if (std::isfinite(expected[i])) {
        ASSERT_FLOAT_EQ(scan.ranges[i], static_cast<float>(expected[i])) << "seed " << seed << ", ray " << i;
      } else {
        ASSERT_FALSE(std::isfinite(scan.ranges[i])) << "seed " << seed << ", ray " << i;
      }
  }
}

}  // namespace
}  // namespace extperfc::scan
