// Clouds of a moving sensor: what is straight stays straight.
#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"

#include "test/unit/scan/vlp16.hpp"

namespace extperfc::scan {
namespace {
constexpr double kSensorHeightM = 0.4;

/// Rotates at `rate` and drives at `speed`, at its origin when the sweep ends.
Pose moving(double rate, double speed, double before_end_s) {
  return make_pose({-speed * before_end_s, 0, kSensorHeightM}, {0, 0, -rate * before_end_s});
}

ScanParams slam_params() {
  auto params = open_params();
  params.angle_increment = 0.4 * kDegree;
  params.min_height = 0.1;
  params.max_height = 1.5;
  return params;
}

/// The track in the base's frame at the stamp, which is the end of the sweep.
SensorTrack track_of(double rate, double speed, const Vlp16& lidar, int poses) {
  SensorTrack track;
  for (int i = 0; i < poses; ++i) {
    const double time_s = lidar.duration_s * i / (poses - 1);
    track.push_back({time_s - lidar.stamp_s, moving(rate, speed, lidar.duration_s - time_s)});
  }
  return track;
}

/// Greatest distance of ray ends from the wall x = 4, |y| < 4.
double error_at_wall(const PlanarScan& scan) {
  double worst = 0;
  int rays = 0;
  for (std::size_t ray = 0; ray < scan.ranges.size(); ++ray) {
    const Eigen::Vector2d end = end_of(scan, ray);
    if (!(end.x() > 2 && std::abs(end.y()) < 4)) continue;
    worst = std::max(worst, std::abs(end.x() - 4));
    ++rays;
  }
  EXPECT_GT(rays, 150);
  return worst;
}

const Scene kWall = plane(Eigen::Vector3d::UnitX(), 4.0);

TEST(Deskew, AWallSeenWhileRotatingIsStraight) {
  const Vlp16 lidar;
  const auto points = revolution(
      kWall, [&](double t) { return moving(0.5, 0, lidar.duration_s - t); }, lidar);
  const CloudBuilder cloud(points);
  const auto skewed = run_both(slam_params(), cloud.view(), {{0, moving(0, 0, 0)}});
  const auto straight = run_both(slam_params(), cloud.view(), track_of(0.5, 0, lidar, 3));
  EXPECT_FALSE(skewed.statistics.deskewed);
  EXPECT_TRUE(straight.statistics.deskewed);
  // Without deskewing the wall's ends (45 degrees, 5.7 m) turn by 0.5 rad/s x up to 0.0625 s.
  EXPECT_GT(error_at_wall(skewed.scans.supported), 0.08);
  // What remains: a ray stands for a bin of 0.4 degrees. Its points lie within half a bin of it: at 45
  // degrees that is 4 m / cos^2 x 0.2 degrees x sin = 0.02 m across the wall, and their mean less.
  EXPECT_LT(error_at_wall(straight.scans.supported), 0.02);
  EXPECT_LT(error_at_wall(straight.scans.nearest), 0.03);
}

TEST(Deskew, DrivingCountsToo) {
  const Vlp16 lidar;
  const auto points = revolution(
      kWall, [&](double t) { return moving(0.3, 1.0, lidar.duration_s - t); }, lidar);
  const CloudBuilder cloud(points);
  EXPECT_GT(error_at_wall(run_both(slam_params(), cloud.view(), {{0, moving(0, 0, 0)}}).scans.supported),
            0.06);
  EXPECT_LT(
      error_at_wall(run_both(slam_params(), cloud.view(), track_of(0.3, 1.0, lidar, 5)).scans.supported),
      0.02);
}

TEST(Deskew, WithoutMomentsThePoseAtTheStampCounts) {
  const Vlp16 lidar;
  const auto points = revolution(
      kWall, [&](double t) { return moving(0.5, 0, lidar.duration_s - t); }, lidar);
  const CloudBuilder cloud(points);
  auto view = cloud.view();
  view.time.reset();
  const auto undone = run_both(slam_params(), view, track_of(0.5, 0, lidar, 3));
  EXPECT_FALSE(undone.statistics.deskewed);
  const auto still = run_both(slam_params(), view, {{0, moving(0, 0, 0)}});
  for (std::size_t i = 0; i < still.scans.nearest.ranges.size(); ++i)
    if (std::isfinite(still.scans.nearest.ranges[i])) {
      ASSERT_EQ(undone.scans.nearest.ranges[i], still.scans.nearest.ranges[i]);
    }
}

TEST(Deskew, MomentsFromTheAzimuth) {
  for (const auto where : {AzimuthTimes::kStampAtEnd, AzimuthTimes::kStampAtStart}) {
    Vlp16 lidar;
    lidar.stamp_s = where == AzimuthTimes::kStampAtEnd ? lidar.duration_s : 0;
    const auto points = revolution(
        kWall, [&](double t) { return moving(0.5, 0, lidar.stamp_s - t); }, lidar);
    const CloudBuilder cloud(points);
    auto view = cloud.view();
    view.time.reset();
    auto params = slam_params();
    params.azimuth_times = where;
    const auto span = time_span(view, where, params.scan_time);
    ASSERT_TRUE(span);
    EXPECT_DOUBLE_EQ(span->last_s - span->first_s, 0.1);
    SensorTrack track;
    for (const double t : {span->first_s, span->last_s}) track.push_back({t, moving(0.5, 0, -t)});
    const auto done = run_both(params, view, track);
    EXPECT_TRUE(done.statistics.deskewed);
    // The first and the last point of a cloud that begins or ends behind the wall tell when the turn was: the
    // wall spans 130 degrees, so up to 64 % of the turn are not there to be counted.
    EXPECT_GT(error_at_wall(run_both(params, view, {{0, moving(0, 0, 0)}}).scans.supported), 0.08);
  }
}

/// A room closes every direction, so that the azimuths span the whole revolution.
TEST(Deskew, MomentsFromTheAzimuthOfAWholeRevolution) {
  const Scene room = all_of({kWall, plane(-Eigen::Vector3d::UnitX(), 5), plane(Eigen::Vector3d::UnitY(), 6),
                             plane(-Eigen::Vector3d::UnitY(), 6)});
  const Vlp16 lidar;
  const auto points = revolution(
      room, [&](double t) { return moving(0.5, 0, lidar.duration_s - t); }, lidar);
  const CloudBuilder cloud(points);
  auto view = cloud.view();
  view.time.reset();
  auto params = slam_params();
  params.azimuth_times = AzimuthTimes::kStampAtEnd;
  const auto done = run_both(params, view, track_of(0.5, 0, lidar, 3));
  EXPECT_TRUE(done.statistics.deskewed);
  EXPECT_LT(error_at_wall(done.scans.supported), 0.02);
  EXPECT_GT(error_at_wall(run_both(params, view, {{0, moving(0, 0, 0)}}).scans.supported), 0.08);
}

TEST(Deskew, PointsOutOfOrderGiveNoMoments) {
  auto points = revolution(floor_at(0), moving(0, 0, 0));
  Rng rng(3);
  for (std::size_t i = points.size() - 1; i > 0; --i)
    std::swap(points[i], points[static_cast<std::size_t>(rng.integer(0, static_cast<int>(i)))]);
  const CloudBuilder cloud(points);
  auto view = cloud.view();
  view.time.reset();
  auto params = slam_params();
  params.azimuth_times = AzimuthTimes::kStampAtEnd;
  EXPECT_FALSE(run_both(params, view, track_of(0.5, 0, {}, 3)).statistics.deskewed);
}

TEST(Deskew, WholeNumbersAreNanosecondsAndAbsoluteTimesCountFromTheStamp) {
  struct Packed {
    float x, y, z;
    std::uint32_t nanoseconds;
    double absolute;
  };
  const std::vector<Packed> packed{{3, 0, 0.5F, 0, 1.6e9}, {3, 0, 0.5F, 50'000'000, 1.6e9 + 0.05}};
  auto view = packed_view(packed);
  view.x = {offsetof(Packed, x), NumberType::kFloat32};
  view.y = {offsetof(Packed, y), NumberType::kFloat32};
  view.z = {offsetof(Packed, z), NumberType::kFloat32};
  const TimeField whole{{offsetof(Packed, nanoseconds), NumberType::kUint32}, 1e-9, 0};
  const TimeField absolute{{offsetof(Packed, absolute), NumberType::kFloat64}, 1.0, 1.6e9};
  for (const auto& field : {whole, absolute}) {
    view.time = field;
    const auto span = time_span(view, AzimuthTimes::kNone, 0.1);
    ASSERT_TRUE(span) << span.error().message;
    EXPECT_NEAR(span->first_s, 0, 1e-6);
    EXPECT_NEAR(span->last_s, 0.05, 1e-6);
    // The sensor turned by 90 degrees between the two points.
    const auto outcome = run_both(open_params(), view,
                                  {{0, Pose::Identity()}, {0.05, make_pose({0, 0, 0}, {0, 0, M_PI / 2})}});
    const auto& scan = outcome.scans.nearest;
    EXPECT_NEAR(scan.ranges[ray_at(scan, 0)], 3, 1e-5);
    EXPECT_NEAR(scan.ranges[ray_at(scan, M_PI / 2)], 3, 1e-5);
  }
}

TEST(Deskew, TimesThatCannotBeAreRefused) {
  const CloudBuilder far({{3, 0, 0.5F, 0, 0, 50.0F}});
  const auto span = time_span(far.view(), AzimuthTimes::kNone, 0.1);
  ASSERT_FALSE(span);
  EXPECT_NE(span.error().message.find("another unit"), std::string::npos) << span.error().message;
  auto view = far.view();
  view.time.reset();
  EXPECT_EQ(time_span(view, AzimuthTimes::kNone, 0.1).error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(time_span(CloudView{}, AzimuthTimes::kStampAtEnd, 0.1));
  auto converter = CloudToScan::make(open_params());
  PlanarScans scans;
  EXPECT_FALSE(converter->convert(far.view(), {}, {}, scans)) << "an empty track";
}

TEST(SensorTrack, EndsHoldAndTheMiddleIsInterpolated) {
  const SensorTrack track{{-0.1, make_pose({0, 0, 1}, {0, 0, -0.2})},
                          {0.1, make_pose({2, 0, 1}, {0, 0, 0.2})}};
  EXPECT_TRUE(pose_at(track, -5).isApprox(track.front().target_T_sensor));
  EXPECT_TRUE(pose_at(track, 5).isApprox(track.back().target_T_sensor));
  EXPECT_TRUE(pose_at(track, 0).isApprox(make_pose({1, 0, 1})));
  EXPECT_TRUE(pose_at(track, 0.05).isApprox(make_pose({1.5, 0, 1}, {0, 0, 0.1})));
}

/// Law: every point's place in the scan is that of the exact pose at its moment.
TEST(DeskewProperty, EveryPointLandsWhereItWas) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Rng rng(seed);
    const Eigen::Vector3d rotation(rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1), rng.uniform(-0.3, 0.3));
    const Eigen::Vector3d translation(rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2),
                                      rng.uniform(-0.02, 0.02));
    const SensorTrack track{{-0.1, Pose::Identity()}, {0, make_pose(translation, rotation)}};
    const TestPoint point{static_cast<float>(rng.uniform(-20, 20)),
                          static_cast<float>(rng.uniform(-20, 20)),
                          static_cast<float>(rng.uniform(-1, 1)),
                          0,
                          0,
                          static_cast<float>(rng.uniform(-0.1, 0))};
    const CloudBuilder cloud({point});
    const auto scan = run_both(open_params(), cloud.view(), track).scans.nearest;
    const Eigen::Vector3d expected =
        pose_at(track, static_cast<double>(point.time_s)) * Eigen::Vector3d(point.x, point.y, point.z);
    ASSERT_EQ(hits(scan), 1U) << "seed " << seed;
    const auto hit =
        std::find_if(scan.ranges.begin(), scan.ranges.end(), [](float r) { return std::isfinite(r); });
    // 0.33 rad in 0.1 s: the table's chord is shorter than the arc by (0.33 / 32)^2 / 8 = 1.4e-5 of 30 m.
    EXPECT_NEAR(*hit, expected.head<2>().norm(), 1e-3) << "seed " << seed;
    const double ray = scan.angle_min + scan.angle_increment * static_cast<double>(hit - scan.ranges.begin());
    EXPECT_LT(std::abs(std::remainder(ray - std::atan2(expected.y(), expected.x()), 2 * M_PI)),
              0.51 * scan.angle_increment)
        << "seed " << seed;
  }
}

}  // namespace
}  // namespace extperfc::scan
