// The scans of a real VLP-16: MRPT's recording of a car park, sensor 2.1 m above the ground.
#include <gtest/gtest.h>

#include "test/unit/scan/cloud_builder.hpp"
#include "test/unit/scan/real_revolution.hpp"

namespace extperfc::scan {
namespace {

constexpr double kSensorHeightM = 2.07;  // ring 0, -15 degrees, meets the ground 8.0 m away

class RealRevolutionTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string why;
    revolution_ = read_real_revolution(why);
    if (revolution_.points.empty()) GTEST_SKIP() << why;
  }

  /// 900 rays, everything between `low` and `high` about the sensor, without a floor.
  static ScanParams band(double low, double high) {
    auto params = open_params();
    params.angle_increment = 2 * M_PI / 900;
    params.min_height = low;
    params.max_height = high;
    params.range_min = 0.5;
    params.range_max = 100;
    return params;
  }

  [[nodiscard]] BothOutcomes see(const ScanParams& params,
                                 const SensorTrack& track = {{0, Pose::Identity()}}) const {
    const auto points = returns_of(revolution_);
    return run_both(params, view_of(points), track);
  }

  RealRevolution revolution_;
};

TEST_F(RealRevolutionTest, IsAWholeRevolution) {
  EXPECT_EQ(revolution_.firings, 1800U);
  EXPECT_EQ(returns_of(revolution_).size(), 22591U);
  const auto span = time_span(revolution_.organised(), AzimuthTimes::kNone, 0.1);
  ASSERT_TRUE(span);
  EXPECT_NEAR(span->last_s - span->first_s, 0.0995, 0.0003);
  EXPECT_NEAR(span->last_s, 0, 1e-6);
}

TEST_F(RealRevolutionTest, TheNearestIsOftenNotTheSupported) {
  // The wider the band, the more often something thin or low stands before the wall.
  std::vector<double> fractions;
  for (const auto& [low, high] : {std::pair{-0.3, 0.3}, {-1.0, 1.0}}) {
    const auto both = see(band(low, high));
    double differ = 0;
    double comparable = 0;
    for (std::size_t i = 0; i < both.scans.nearest.ranges.size(); ++i) {
      if (!std::isfinite(both.scans.supported.ranges[i])) continue;
      ++comparable;
      differ += both.scans.supported.ranges[i] - both.scans.nearest.ranges[i] > 0.3F ? 1 : 0;
      ASSERT_GE(both.scans.supported.ranges[i], both.scans.nearest.ranges[i]);
    }
    ASSERT_GT(comparable, 300);
    fractions.push_back(differ / comparable);
    RecordProperty("fraction_" + std::to_string(fractions.size()), std::to_string(fractions.back()));
  }
  EXPECT_GT(fractions.back(), 0.02);
  EXPECT_LT(fractions.front(), fractions.back());
}

TEST_F(RealRevolutionTest, UnseenRaysAreNeverFree) {
  auto params = band(-1.0, 1.0);
  params.range_max = 30;
  const auto both = see(params);
  const auto& s = both.statistics;
  EXPECT_EQ(s.rays_met + s.rays_free + s.rays_unknown, 900U);
  EXPECT_EQ(s.on_robot, 0U);
  // Free rays are those whose beams came back from beyond 30 m: there must be such a point in the ray.
  const auto points = returns_of(revolution_);
  for (std::size_t ray = 0; ray < 900; ++ray) {
    if (!std::isinf(both.scans.nearest.ranges[ray])) continue;
    const double angle =
        both.scans.nearest.angle_min + both.scans.nearest.angle_increment * static_cast<double>(ray);
    const bool seen = std::any_of(points.begin(), points.end(), [&](const VelodynePoint& p) {
      return std::hypot(p.x, p.y) > 30 &&
             std::abs(std::remainder(std::atan2(p.y, p.x) - angle, 2 * M_PI)) < 0.51 * params.angle_increment;
    });
    ASSERT_TRUE(seen) << "ray " << ray;
  }
}

TEST_F(RealRevolutionTest, SilentBeamsAddFreeRaysOnly) {
  auto params = band(-1.0, 1.0);
  params.range_max = 30;
  const auto without = run_both(params, revolution_.organised(), {{0, Pose::Identity()}});
  params.no_return_range = 60;
  const auto with = run_both(params, revolution_.organised(), {{0, Pose::Identity()}});
  EXPECT_GT(with.statistics.rays_free, without.statistics.rays_free);
  EXPECT_EQ(with.statistics.rays_met, without.statistics.rays_met);
  for (std::size_t ray = 0; ray < 900; ++ray)
    if (std::isfinite(without.scans.nearest.ranges[ray])) {
      ASSERT_EQ(without.scans.nearest.ranges[ray], with.scans.nearest.ranges[ray]);
    }
}

TEST_F(RealRevolutionTest, TheGroundIsFoundByEveryMethod) {
  const auto points = returns_of(revolution_);
  const Pose ground_T_sensor = make_pose({0, 0, kSensorHeightM});
  for (const auto method : {GroundMethod::kHeight, GroundMethod::kPlane, GroundMethod::kSlope}) {
    auto params = band(-0.5, 2.0);
    params.range_min = 3;
    params.range_max = 12;  // ring 0 meets the ground at 7.7 m, ring 1 at 8.8 m, ring 2 at 10.9 m
    params.ground.method = method;
    params.ground.clearance_m = 0.2;
    const auto both = run_both(params, view_of(points), {{0, ground_T_sensor}});
    EXPECT_GT(both.statistics.on_ground, 2000U) << to_string(method);
    params.ground.method = GroundMethod::kNone;
    const auto all = run_both(params, view_of(points), {{0, ground_T_sensor}});
    EXPECT_LT(both.statistics.rays_met, all.statistics.rays_met) << to_string(method);
  }
}

TEST_F(RealRevolutionTest, RotationByDeskewingIsUndoneByRotatingBack) {
  // Law: deskewing with a turn of the whole sensor by a constant angle turns the scan by that angle.
  auto params = band(-0.3, 0.3);
  const double bins = 50;
  const auto still = see(params);
  const Pose turned = make_pose({0, 0, 0}, {0, 0, bins * params.angle_increment});
  const auto both = see(params, {{-0.1, turned}, {0, turned}});
  EXPECT_TRUE(both.statistics.deskewed);
  std::size_t same = 0;
  for (std::size_t ray = 0; ray < 900; ++ray) {
    const float a = still.scans.supported.ranges[ray];
    const float b = both.scans.supported.ranges[(ray + 50) % 900];
    same += (std::isnan(a) && std::isnan(b)) || std::abs(a - b) < 0.01F ? 1 : 0;
  }
  EXPECT_GT(same, 890U) << "but for points at the very edge of a bin";
}

}  // namespace
}  // namespace extperfc::scan
