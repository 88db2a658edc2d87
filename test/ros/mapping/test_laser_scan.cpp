// sensor_msgs/LaserScan and MultiEchoLaserScan -> the core's scan.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "ros/convert/laser_scan.hpp"

namespace extperfc::ros_convert {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

sensor_msgs::LaserScan message() {
  sensor_msgs::LaserScan scan;
  scan.header.frame_id = "laser";
  scan.header.stamp = ros::Time(12, 500000000);
  scan.angle_min = -1.0F;
  scan.angle_max = 1.0F;
  scan.angle_increment = 0.5F;
  scan.range_min = 0.1F;
  scan.range_max = 10.0F;
  scan.ranges = {1, 2, kNan, kInf, 5};
  return scan;
}

/// Where ray `i` ends, in the frame of the base.
Pose2 end_of(const LaserScan& scan, std::size_t i) {
  const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
  const double range = static_cast<double>(scan.ranges[i]);
  return compose(scan.base_T_sensor, {range * std::cos(angle), range * std::sin(angle), 0});
}

/// The same by the whole pose in space.
Eigen::Vector3d end_in_space(const sensor_msgs::LaserScan& scan, const Pose& base_T_scanner, std::size_t i) {
  const double angle = static_cast<double>(scan.angle_min) +
                       static_cast<double>(i) * static_cast<double>(scan.angle_increment);
  const double range = static_cast<double>(scan.ranges[i]);
  return base_T_scanner * Eigen::Vector3d(range * std::cos(angle), range * std::sin(angle), 0);
}

TEST(ToLaserScan, EverythingArrives) {
  const auto scan = to_laser_scan(message(), make_pose({0.3, -0.1, 0.5}, {0, 0, 0.7}));
  ASSERT_TRUE(scan) << scan.error().message;
  EXPECT_DOUBLE_EQ(scan->stamp_s, 12.5);
  EXPECT_DOUBLE_EQ(scan->angle_min, -1.0);
  EXPECT_DOUBLE_EQ(scan->angle_increment, 0.5);
  EXPECT_NEAR(scan->range_min, 0.1, 1e-7);
  EXPECT_DOUBLE_EQ(scan->range_max, 10.0);
  EXPECT_DOUBLE_EQ(scan->base_T_sensor.x, 0.3);
  EXPECT_DOUBLE_EQ(scan->base_T_sensor.y, -0.1);
  EXPECT_NEAR(scan->base_T_sensor.yaw, 0.7, 1e-12);
  ASSERT_EQ(scan->ranges.size(), 5U);
  EXPECT_EQ(scan->ranges[1], 2.0F);
  EXPECT_TRUE(std::isnan(scan->ranges[2]));
  EXPECT_TRUE(std::isinf(scan->ranges[3]));
  EXPECT_EQ(count_returns(*scan), 3U);
}

/// The law behind both: a ray ends where the whole transform puts it, seen from above.
TEST(ToLaserScan, RaysEndWhereTheTransformPutsThem) {
  for (const double roll : {0.0, M_PI, -M_PI})
    for (const double yaw : {-3.0, -1.2, 0.0, 0.4, 2.5}) {
      const Pose base_T_scanner = make_pose({0.2, 0.1, 0.8}, {roll, 0, yaw});
      const auto scan = to_laser_scan(message(), base_T_scanner);
      ASSERT_TRUE(scan) << scan.error().message;
      for (const std::size_t i : {0U, 1U, 4U}) {
        const auto expected = end_in_space(message(), base_T_scanner, i);
        EXPECT_NEAR(end_of(*scan, i).x, expected.x(), 1e-9) << roll << " " << yaw;
        EXPECT_NEAR(end_of(*scan, i).y, expected.y(), 1e-9) << roll << " " << yaw;
      }
    }
}

TEST(ToLaserScan, ASlightTiltIsNoMatter) {
  EXPECT_TRUE(to_laser_scan(message(), make_pose({0, 0, 0}, {0.05, 0.05, 1})));
  EXPECT_TRUE(to_laser_scan(message(), make_pose({0, 0, 0}, {M_PI - 0.05, 0.05, 1})));
}

TEST(ToLaserScan, ATiltedScannerIsRefused) {
  const auto scan = to_laser_scan(message(), make_pose({0, 0, 0}, {0, 0.2, 0}));
  ASSERT_FALSE(scan);
  EXPECT_EQ(scan.error().code, ErrorCode::kInvalidArgument);
  EXPECT_NE(scan.error().message.find("laser is tilted by 11.5 degrees"), std::string::npos)
      << scan.error().message;
  EXPECT_TRUE(to_laser_scan(message(), make_pose({0, 0, 0}, {0, 0.2, 0}), 0.3));
  EXPECT_FALSE(to_laser_scan(message(), make_pose({0, 0, 0}, {0, M_PI / 2, 0}), 0.8));
}

TEST(ToLaserScan, ATransformThatIsNoneIsRefused) {
  Pose broken = Pose::Identity();
  broken.linear()(2, 2) = std::nan("");
  EXPECT_FALSE(to_laser_scan(message(), broken));
}

TEST(ToLaserScan, WhatTheCoreRefusesIsRefused) {
  auto empty = message();
  empty.ranges.clear();
  EXPECT_FALSE(to_laser_scan(empty, Pose::Identity()));
  auto still = message();
  still.angle_increment = 0;
  EXPECT_FALSE(to_laser_scan(still, Pose::Identity()));
}

sensor_msgs::LaserEcho echoes(std::vector<float> values) {
  sensor_msgs::LaserEcho echo;
  echo.echoes = std::move(values);
  return echo;
}

sensor_msgs::MultiEchoLaserScan multi_echo() {
  sensor_msgs::MultiEchoLaserScan scan;
  scan.header.frame_id = "laser";
  scan.header.stamp = ros::Time(3, 4);
  scan.angle_min = -1;
  scan.angle_max = 1;
  scan.angle_increment = 0.5F;
  scan.time_increment = 0.001F;
  scan.scan_time = 0.1F;
  scan.range_min = 0.1F;
  scan.range_max = 10;
  scan.ranges = {echoes({1, 2}), echoes({3}), echoes({}), echoes({kNan, 4}), echoes({kInf})};
  scan.intensities = {echoes({5, 9}), echoes({7}), echoes({}), echoes({100, 6}), echoes({1})};
  return scan;
}

TEST(ToSingleEcho, TheStrongestCounts) {
  const auto scan = to_single_echo(multi_echo());
  EXPECT_EQ(scan.header.frame_id, "laser");
  EXPECT_EQ(scan.header.stamp, ros::Time(3, 4));
  EXPECT_EQ(scan.angle_min, -1);
  EXPECT_EQ(scan.angle_max, 1);
  EXPECT_EQ(scan.angle_increment, 0.5F);
  EXPECT_EQ(scan.time_increment, 0.001F);
  EXPECT_EQ(scan.scan_time, 0.1F);
  EXPECT_EQ(scan.range_min, 0.1F);
  EXPECT_EQ(scan.range_max, 10);
  ASSERT_EQ(scan.ranges.size(), 5U);
  EXPECT_EQ(scan.ranges[0], 2);
  EXPECT_EQ(scan.ranges[1], 3);
  EXPECT_TRUE(std::isnan(scan.ranges[2])) << "a ray without echo is unknown";
  EXPECT_EQ(scan.ranges[3], 4) << "a measurement, not a stronger missing echo";
  EXPECT_TRUE(std::isinf(scan.ranges[4]));
  EXPECT_EQ(scan.intensities, (std::vector<float>{9, 7, 0, 6, 1}));
}

TEST(ToSingleEcho, TheFirstCountsWithoutIntensities) {
  auto message = multi_echo();
  message.intensities.clear();
  const auto scan = to_single_echo(message);
  EXPECT_EQ(scan.ranges[0], 1);
  EXPECT_EQ(scan.ranges[3], 4);
  EXPECT_TRUE(scan.intensities.empty());
}

TEST(ToSingleEcho, IntensitiesOfAnotherNumberDoNotCount) {
  auto message = multi_echo();
  message.intensities[0] = echoes({5});
  EXPECT_EQ(to_single_echo(message).ranges[0], 1);
  message.intensities.pop_back();
  EXPECT_EQ(to_single_echo(message).ranges.size(), 5U);
}

}  // namespace
}  // namespace extperfc::ros_convert
