// sensor_msgs/PointCloud2 and LaserScan <-> the core's cloud and scan.
#include <gtest/gtest.h>

#include "ros/convert/scan.hpp"
#include "test/ros/scan/cloud_message.hpp"

namespace extperfc::ros_convert {
namespace {

using ros_test::cloud_message;
using sensor_msgs::PointField;

TEST(ToCloudView, SharesTheMessagesMemory) {
  const auto message = cloud_message({{1, 2, 3, 4, 5, 0}, {6, 7, 8, 9, 10, 0}}, ros::Time(1, 0));
  const auto cloud = to_cloud_view(*message);
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->data, message->data.data());
  EXPECT_EQ(cloud->size(), 2U);
  EXPECT_EQ(cloud->point_step, 20U);
  EXPECT_EQ(cloud->y.offset, 4U);
  ASSERT_TRUE(cloud->intensity && cloud->ring);
  EXPECT_EQ(cloud->intensity->offset, 12U);
  EXPECT_EQ(cloud->ring->type, scan::NumberType::kUint16);
  EXPECT_TRUE(scan::validate(*cloud));
}

TEST(ToCloudView, EveryNumberType) {
  for (std::uint8_t datatype = PointField::INT8; datatype <= PointField::FLOAT64; ++datatype) {
    const auto message = cloud_message({{1, 2, 3, 4, 5, 0}}, ros::Time(1, 0));
    message->fields[3].datatype = datatype;
    const auto cloud = to_cloud_view(*message);
    ASSERT_TRUE(cloud) << cloud.error().message;
    const std::size_t expected[] = {0, 1, 1, 2, 2, 4, 4, 4, 8};
    EXPECT_EQ(scan::bytes_of(cloud->intensity->type), expected[datatype]);
  }
}

TEST(ToCloudView, IntensityAndRingMayBeMissing) {
  const auto message = cloud_message({{1, 2, 3, 4, 5, 0}}, ros::Time(1, 0));
  message->fields.resize(3);
  const auto cloud = to_cloud_view(*message);
  ASSERT_TRUE(cloud);
  EXPECT_FALSE(cloud->intensity);
  EXPECT_FALSE(cloud->ring);
}

TEST(ToCloudView, IntensityMayBeCalledI) {
  const auto message = cloud_message({{1, 2, 3, 4, 5, 0}}, ros::Time(1, 0));
  message->fields[3].name = "i";
  EXPECT_EQ(to_cloud_view(*message)->intensity->offset, 12U);
}

TEST(ToCloudView, WhatIsMissingIsNamed) {
  const auto message = cloud_message({{1, 2, 3, 4, 5, 0}}, ros::Time(1, 0));
  message->fields[1].name = "Y";
  const auto cloud = to_cloud_view(*message);
  ASSERT_FALSE(cloud);
  EXPECT_EQ(cloud.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(cloud.error().message, "the cloud has no field 'y'; its fields: x, Y, z, intensity, ring");
}

TEST(ToCloudView, TypesThatNobodyKnowsAreRefused) {
  const auto message = cloud_message({{1, 2, 3, 4, 5, 0}}, ros::Time(1, 0));
  message->fields[2].datatype = 9;
  EXPECT_FALSE(to_cloud_view(*message));
  message->fields[2].datatype = PointField::FLOAT32;
  message->fields[2].count = 3;
  EXPECT_FALSE(to_cloud_view(*message));
  message->fields[2].count = 0;
  EXPECT_TRUE(to_cloud_view(*message)) << "some drivers write 0 for one number";
}

TEST(ToCloudView, AnEmptyCloudNeedsNoFields) {
  const sensor_msgs::PointCloud2 message;
  const auto cloud = to_cloud_view(message);
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->size(), 0U);
}

TEST(ToLaserScan, EverythingArrives) {
  scan::PlanarScan scan;
  scan.angle_min = -1;
  scan.angle_max = 1;
  scan.angle_increment = 1;
  scan.ranges = {1, 2, 3};
  scan.intensities = {4, 5, 6};
  std_msgs::Header header;
  header.frame_id = "base_link";
  header.stamp = ros::Time(7, 8);
  const auto message = to_message(scan, {0.1, 0.4, 30}, header);
  EXPECT_EQ(message.header.frame_id, "base_link");
  EXPECT_EQ(message.header.stamp, ros::Time(7, 8));
  EXPECT_FLOAT_EQ(message.angle_min, -1);
  EXPECT_FLOAT_EQ(message.angle_max, 1);
  EXPECT_FLOAT_EQ(message.angle_increment, 1);
  EXPECT_FLOAT_EQ(message.time_increment, 0);
  EXPECT_FLOAT_EQ(message.scan_time, 0.1F);
  EXPECT_FLOAT_EQ(message.range_min, 0.4F);
  EXPECT_FLOAT_EQ(message.range_max, 30);
  EXPECT_EQ(message.ranges, scan.ranges);
  EXPECT_EQ(message.intensities, scan.intensities);
}

}  // namespace
}  // namespace extperfc::ros_convert
