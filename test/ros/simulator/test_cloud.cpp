#include <gtest/gtest.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include "ros/convert/cloud.hpp"

namespace extperfc::ros_convert {
namespace {

using simulate::LidarPoint;

std_msgs::Header header() {
  std_msgs::Header h;
  h.stamp = ros::Time(12, 500000000);
  h.frame_id = "velodyne";
  return h;
}

TEST(Cloud, HasTheLayoutOfVelodynePointcloud) {
  const auto cloud = to_message({{1, 2, 3, 4, 5, 0.05F}}, 0.1, header());
  EXPECT_EQ(cloud->header.frame_id, "velodyne");
  EXPECT_EQ(cloud->header.stamp, header().stamp);
  EXPECT_EQ(cloud->point_step, 22U);
  EXPECT_EQ(cloud->height, 1U);
  ASSERT_EQ(cloud->fields.size(), 6U);
  const std::vector<std::string> names{"x", "y", "z", "intensity", "ring", "time"};
  const std::vector<std::uint32_t> offsets{0, 4, 8, 12, 16, 18};
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(cloud->fields[i].name, names[i]);
    EXPECT_EQ(cloud->fields[i].offset, offsets[i]);
    EXPECT_EQ(cloud->fields[i].count, 1U);
    EXPECT_EQ(cloud->fields[i].datatype,
              i == 4 ? sensor_msgs::PointField::UINT16 : sensor_msgs::PointField::FLOAT32);
  }
}

TEST(Cloud, PointsComeBack) {
  std::vector<LidarPoint> points;
  for (int i = 0; i < 50; ++i) {
    const auto v = static_cast<float>(i);
    points.push_back({v, -v, 0.5F * v, 2 * v, static_cast<std::uint16_t>(i % 16), 0.002F * v});
  }
  const auto cloud = to_message(points, 0.1, header());
  ASSERT_EQ(cloud->width, 50U);
  ASSERT_EQ(cloud->data.size(), 50U * 22U);
  sensor_msgs::PointCloud2ConstIterator<float> x(*cloud, "x");
  sensor_msgs::PointCloud2ConstIterator<float> intensity(*cloud, "intensity");
  sensor_msgs::PointCloud2ConstIterator<std::uint16_t> ring(*cloud, "ring");
  sensor_msgs::PointCloud2ConstIterator<float> time(*cloud, "time");
  for (std::size_t i = 0; i < points.size(); ++i, ++x, ++intensity, ++ring, ++time) {
    EXPECT_EQ(x[0], points[i].x);
    EXPECT_EQ(x[1], points[i].y);
    EXPECT_EQ(x[2], points[i].z);
    EXPECT_EQ(*intensity, points[i].intensity);
    EXPECT_EQ(*ring, points[i].ring);
    EXPECT_FLOAT_EQ(*time, points[i].time - 0.1F) << "counted from the stamp, which is the sweep's end";
    EXPECT_LE(*time, 0.0F);
  }
}

TEST(Cloud, NothingIsAnEmptyCloud) {
  const auto cloud = to_message({}, 0.1, header());
  EXPECT_EQ(cloud->width, 0U);
  EXPECT_TRUE(cloud->data.empty());
  EXPECT_EQ(cloud->fields.size(), 6U);
}

}  // namespace
}  // namespace extperfc::ros_convert
