#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/sources/scan_pairing.hpp"

namespace extperfc::sources {
namespace {

ScanRecord scan_at(double stamp_s, std::size_t index = 0) {
  ScanRecord record;
  record.scan.stamp_s = stamp_s;
  record.index = index;
  return record;
}

TEST(ScanPairing, ScansGetThePoseBetweenTheirNeighbours) {
  ScanPairing pairing;
  pairing.add_odometry(10.0, {0, 0, 3.0});
  pairing.add_scan(scan_at(10.25));
  EXPECT_FALSE(pairing.take()) << "odometry has not passed the scan yet";
  pairing.add_odometry(11.0, {4, -8, -3.0});
  const auto record = pairing.take();
  ASSERT_TRUE(record && record->odom_T_base);
  EXPECT_DOUBLE_EQ(record->odom_T_base->x, 1);
  EXPECT_DOUBLE_EQ(record->odom_T_base->y, -2);
  EXPECT_NEAR(record->odom_T_base->yaw, 3.0 + (2 * M_PI - 6) / 4, 1e-12);  // the short way round
  EXPECT_FALSE(pairing.take());
}

TEST(ScanPairing, ScansLeaveInTheirOrder) {
  ScanPairing pairing;
  for (std::size_t i = 0; i < 10; ++i) pairing.add_scan(scan_at(0.05 * static_cast<double>(i), i));
  for (int i = 0; i < 10; ++i) pairing.add_odometry(0.06 * i, {static_cast<double>(i), 0, 0});
  for (std::size_t i = 0; i < 10; ++i) {
    const auto record = pairing.take();
    ASSERT_TRUE(record) << i;
    EXPECT_EQ(record->index, i);
    ASSERT_TRUE(record->odom_T_base);
    EXPECT_NEAR(record->odom_T_base->x, 0.05 * static_cast<double>(i) / 0.06, 1e-9);
  }
}

TEST(ScanPairing, WithoutOdometryScansPassAfterASecond) {
  ScanPairing pairing;
  pairing.add_scan(scan_at(1.0));
  pairing.add_scan(scan_at(1.9));
  EXPECT_FALSE(pairing.take());
  pairing.add_scan(scan_at(2.1));
  const auto record = pairing.take();
  ASSERT_TRUE(record);
  EXPECT_DOUBLE_EQ(record->scan.stamp_s, 1.0);
  EXPECT_FALSE(record->odom_T_base);
  EXPECT_FALSE(pairing.take());
  pairing.finish();
  EXPECT_TRUE(pairing.take() && pairing.take());
  EXPECT_FALSE(pairing.take());
}

TEST(ScanPairing, GapsAreNotBridged) {
  ScanPairing pairing;
  pairing.add_odometry(0, {0, 0, 0});
  pairing.add_odometry(5, {5, 0, 0});
  pairing.add_scan(scan_at(2));
  const auto record = pairing.take();
  ASSERT_TRUE(record);
  EXPECT_FALSE(record->odom_T_base);
}

TEST(ScanPairing, JustBesideTheEndsIsNearEnough) {
  ScanPairing pairing;
  pairing.add_odometry(1.0, {1, 0, 0});
  pairing.add_odometry(1.5, {2, 0, 0});
  EXPECT_EQ(pairing.at(0.95)->x, 1);
  EXPECT_EQ(pairing.at(1.55)->x, 2);
  EXPECT_FALSE(pairing.at(0.8));
  EXPECT_FALSE(pairing.at(1.7));
  EXPECT_FALSE(ScanPairing().at(1));
}

TEST(ScanPairing, NothingIsPairedAcrossANewStart) {
  ScanPairing pairing;
  pairing.add_odometry(100, {9, 9, 0});
  pairing.add_scan(scan_at(100.5, 0));
  pairing.add_scan(scan_at(1.0, 1));  // the recording starts again
  pairing.add_odometry(0.9, {1, 0, 0});
  pairing.add_odometry(1.1, {2, 0, 0});
  const auto before = pairing.take();
  ASSERT_TRUE(before);
  EXPECT_EQ(before->index, 0U);
  EXPECT_FALSE(before->odom_T_base);
  const auto after = pairing.take();
  ASSERT_TRUE(after && after->odom_T_base);
  EXPECT_EQ(after->index, 1U);
  EXPECT_NEAR(after->odom_T_base->x, 1.5, 1e-9);
}

TEST(ScanPairing, MemoryIsBounded) {
  ScanPairing pairing;
  for (std::size_t i = 0; i < 10 * ScanPairing::kMaxWaiting; ++i) pairing.add_scan(scan_at(0, i));
  std::size_t taken = 0;
  while (pairing.take()) ++taken;
  EXPECT_EQ(taken, 9 * ScanPairing::kMaxWaiting);
}

TEST(ScanPairing, RepeatedOdometryIsHarmless) {
  ScanPairing pairing;
  for (int i = 0; i < 3; ++i) pairing.add_odometry(1.0, {1, 0, 0});
  pairing.add_odometry(0.9, {7, 0, 0});  // a little late
  pairing.add_odometry(1.2, {3, 0, 0});
  EXPECT_NEAR(pairing.at(1.1)->x, 2, 1e-9);
  EXPECT_EQ(pairing.at(1.0)->x, 1);
}

}  // namespace
}  // namespace extperfc::sources
