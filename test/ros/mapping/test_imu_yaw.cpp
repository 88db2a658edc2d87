#include <cmath>
#include <limits>
#include <thread>

#include <gtest/gtest.h>

#include "ros/mapping/imu_yaw.hpp"

namespace extperfc::ros_mapping {
namespace {

sensor_msgs::Imu with_orientation(double stamp_s, const Pose& world_T_imu) {
  sensor_msgs::Imu message;
  message.header.stamp.fromSec(stamp_s);
  message.header.frame_id = "imu_link";
  const Eigen::Quaterniond q(world_T_imu.linear());
  message.orientation.x = q.x();
  message.orientation.y = q.y();
  message.orientation.z = q.z();
  message.orientation.w = q.w();
  return message;
}

sensor_msgs::Imu level(double stamp_s, double yaw_rad) {
  return with_orientation(stamp_s, make_pose({0, 0, 0}, {0, 0, yaw_rad}));
}

sensor_msgs::Imu with_rate(double stamp_s, double rate_rad_s) {
  sensor_msgs::Imu message;
  message.header.stamp.fromSec(stamp_s);
  message.header.frame_id = "imu_link";
  message.orientation_covariance[0] = -1;
  message.angular_velocity.z = rate_rad_s;
  return message;
}

TEST(ImuYaw, LiesBetweenItsNeighbours) {
  ImuYaw imu;
  EXPECT_FALSE(imu.at(1.0, 0.0));
  imu.add(level(1.0, 0.1));
  imu.add(level(1.1, 0.2));
  EXPECT_NEAR(imu.at(1.0, 0.0).value(), 0.1, 1e-9);
  EXPECT_NEAR(imu.at(1.05, 0.0).value(), 0.15, 1e-6);
  EXPECT_NEAR(imu.at(1.1, 0.0).value(), 0.2, 1e-6);
  EXPECT_FALSE(imu.at(0.9, 0.0)) << "older than what is kept";
  EXPECT_FALSE(imu.at(1.2, 0.0)) << "not measured yet";
}

TEST(ImuYaw, UnwrapsYaw) {
  ImuYaw imu;
  for (int i = 0; i <= 100; ++i) imu.add(level(0.1 * i, wrap_angle(0.2 * i)));
  EXPECT_NEAR(imu.at(10.0, 0.0).value() - imu.at(0.0, 0.0).value(), 20.0, 1e-6);
}

TEST(ImuYaw, TurningRatesAreIntegrated) {
  ImuYaw imu;
  for (int i = 0; i <= 100; ++i) imu.add(with_rate(0.01 * i, 0.01 * i));  // yaw = t^2 / 2
  EXPECT_NEAR(imu.at(1.0, 0.0).value() - imu.at(0.0, 0.0).value(), 0.5, 1e-6);
}

TEST(ImuYaw, AnImuThatIsMountedOtherwise) {
  const Pose base_T_imu = make_pose({0, 0, 0}, {M_PI, 0, 0.4});  // upside down
  ImuYaw imu;
  imu.add(level(0.0, 0.0));
  EXPECT_EQ(imu.unknown_frame(), "imu_link");
  imu.set_mount("imu_link", base_T_imu);
  EXPECT_EQ(imu.unknown_frame(), "");
  for (int i = 0; i <= 10; ++i)
    imu.add(with_orientation(1 + 0.1 * i, make_pose({0, 0, 0}, {0.02, -0.03, 0.05 * i}) * base_T_imu));
  EXPECT_NEAR(imu.at(2.0, 0.0).value() - imu.at(1.0, 0.0).value(), 0.5, 1e-6);
  ImuYaw gyro;
  gyro.add(with_rate(0.0, 0.0));
  gyro.set_mount("imu_link", base_T_imu);
  for (int i = 0; i <= 10; ++i) gyro.add(with_rate(1 + 0.1 * i, -0.5));
  EXPECT_NEAR(gyro.at(2.0, 0.0).value() - gyro.at(1.0, 0.0).value(), 0.5, 1e-6);
}

TEST(ImuYaw, GapsAreNotBridged) {
  ImuYaw imu;
  imu.add(level(1.0, 0.0));
  imu.add(level(3.0, 1.0));
  EXPECT_FALSE(imu.at(2.0, 0.0));
}

TEST(ImuYaw, TimeThatRanBackStartsAnew) {
  ImuYaw imu;
  imu.add(level(100.0, 0.0));
  imu.add(level(1.0, 0.5));
  imu.add(level(1.1, 0.6));
  EXPECT_NEAR(imu.at(1.1, 0.0).value() - imu.at(1.0, 0.0).value(), 0.1, 1e-6);
  EXPECT_FALSE(imu.at(100.0, 0.0));
}

TEST(ImuYaw, WhatIsNoMeasurementIsIgnored) {
  ImuYaw imu;
  auto zero = level(1.0, 0.0);
  zero.orientation.w = 0;
  imu.add(zero);
  auto broken = level(1.1, 0.0);
  broken.orientation.z = std::numeric_limits<double>::quiet_NaN();
  imu.add(broken);
  imu.add(with_rate(1.2, std::numeric_limits<double>::infinity()));
  EXPECT_EQ(imu.received(), 3U);
  EXPECT_EQ(imu.ignored(), 3U);
  EXPECT_FALSE(imu.at(1.1, 0.0));
}

TEST(ImuYaw, WaitsForTheLaterNeighbour) {
  ImuYaw imu;
  imu.add(level(1.0, 0.0));
  std::thread later([&] { imu.add(level(1.1, 0.1)); });
  EXPECT_NEAR(imu.at(1.05, 60.0).value(), 0.05, 1e-6);
  later.join();
}

TEST(ImuYaw, DoesNotWaitForASilentImu) {
  ImuYaw imu;
  EXPECT_FALSE(imu.at(5.0, 3600.0)) << "never heard of";
  imu.add(level(1.0, 0.0));
  EXPECT_FALSE(imu.at(5.0, 3600.0)) << "silent for 4 s";
}

TEST(ImuYaw, ClosingEndsTheWait) {
  ImuYaw imu;
  imu.add(level(1.0, 0.0));
  std::thread closer([&] { imu.close(); });
  EXPECT_FALSE(imu.at(1.2, 3600.0));
  closer.join();
}

TEST(ImuYaw, MemoryIsBounded) {
  ImuYaw imu;
  for (int i = 0; i < 10000; ++i) imu.add(level(0.01 * i, 0.0));
  EXPECT_FALSE(imu.at(1.0, 0.0));
  EXPECT_TRUE(imu.at(99.0, 0.0));
}

}  // namespace
}  // namespace extperfc::ros_mapping
