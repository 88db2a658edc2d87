// Roll and pitch taken away: a robot that rocks sees no obstacle in the floor.
#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/scan/level.hpp"

#include "test/unit/scan/vlp16.hpp"

namespace extperfc::scan {
namespace {

Eigen::Matrix3d rotation(double roll, double pitch, double yaw) {
  return make_pose({0, 0, 0}, {roll, pitch, yaw}).linear();
}

TEST(Level, TiltIsRollAndPitchWithoutHeading) {
  EXPECT_TRUE(tilt_of(rotation(0, 0, 1.2)).isApprox(Eigen::Matrix3d::Identity()));
  EXPECT_TRUE(tilt_of(rotation(0.1, -0.2, 1.2)).isApprox(rotation(0.1, -0.2, 0)));
  EXPECT_NEAR(tilt_angle_rad(rotation(0.1, 0, 2)), 0.1, 1e-9);
  const Eigen::Matrix3d up = rotation(0, -M_PI / 2, 0);
  EXPECT_TRUE(tilt_of(up).isApprox(up)) << "without a heading the whole rotation stays";
}

/// Laws: R = R_z(heading) tilt; upright() is idempotent and keeps heading and place; with_tilt() takes the
/// tilt.
TEST(LevelProperty, HeadingTimesTiltIsTheRotation) {
  Rng rng(2);
  for (int i = 0; i < 500; ++i) {
    const Pose pose = make_pose({rng.uniform(-5, 5), rng.uniform(-5, 5), rng.uniform(-1, 1)},
                                {rng.uniform(-3, 3), rng.uniform(-1.5, 1.5), rng.uniform(-3, 3)});
    const Pose level = upright(pose);
    ASSERT_TRUE((level.linear() * tilt_of(pose.linear())).isApprox(pose.linear(), 1e-9)) << i;
    ASSERT_TRUE(upright(level).isApprox(level, 1e-9)) << i;
    ASSERT_NEAR(tilt_angle_rad(level.linear()), 0, 1e-7) << i;
    ASSERT_EQ(level.translation(), pose.translation());
    const Pose other = with_tilt(level, pose.linear());
    ASSERT_TRUE(other.isApprox(pose, 1e-9)) << i;
  }
}

TEST(Level, ARockingRobotSeesNoObstacleInTheFloor) {
  const Pose base_T_sensor = make_pose({0, 0, 0.4});
  auto params = open_params();
  params.min_height = 0.1;
  params.max_height = 1.5;
  params.range_max = 20;
  params.ground.method = GroundMethod::kHeight;
  for (const auto& [roll, pitch] : {std::pair{0.0, 3.0}, {0.0, -3.0}, {2.0, 0.0}, {-2.0, 2.0}}) {
    const Pose world_T_base = make_pose({5, -2, 0}, {roll * kDegree, pitch * kDegree, 0.7});
    Vlp16 lidar;
    lidar.noise_m = 0.01;
    const auto points = revolution(floor_at(0), world_T_base * base_T_sensor, lidar);
    const auto tilted = run(params, points, base_T_sensor);
    EXPECT_GT(hits(tilted.scan), 60U) << "the floor ahead rises into the band";
    const Pose level_T_base = upright(world_T_base).inverse() * world_T_base;
    const auto level = run(params, points, level_T_base * base_T_sensor);
    EXPECT_EQ(hits(level.scan), 0U) << roll << " " << pitch;
  }
}

TEST(Level, AWallStaysWhereItIs) {
  const Pose base_T_sensor = make_pose({0, 0, 0.4});
  const Pose world_T_base = make_pose({0, 0, 0}, {2 * kDegree, -3 * kDegree, 0});
  const auto points =
      revolution(all_of({floor_at(0), plane(Eigen::Vector3d::UnitX(), 4)}), world_T_base * base_T_sensor);
  auto params = open_params();
  params.min_height = 0.1;
  params.max_height = 1.5;
  params.ground.method = GroundMethod::kHeight;
  const auto both = run_both(params, points, world_T_base * base_T_sensor);
  for (const double angle : {-0.5, 0.0, 0.5}) {
    const auto& scan = both.scans.supported;
    EXPECT_NEAR(scan.ranges[ray_at(scan, angle)], 4 / std::cos(std::abs(angle)), 0.03) << angle;
  }
}

}  // namespace
}  // namespace extperfc::scan
