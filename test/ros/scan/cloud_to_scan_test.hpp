#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <geometry_msgs/TransformStamped.h>
#include <gtest/gtest.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include "test/ros/scan/cloud_message.hpp"
#include "test/ros/support/inbox.hpp"
#include "test/ros/support/manager.hpp"
#include "test/ros/support/watch.hpp"

namespace extperfc::ros_test {

constexpr double kSensorHeightM = 0.8;

/// A wall at x = 3 m from the floor to 1.2 m and the floor before it, seen from a sensor above base_link.
inline std::vector<CloudPoint> wall_and_floor() {
  std::vector<CloudPoint> points;
  constexpr auto kFloor = static_cast<float>(-kSensorHeightM);
  for (int y = -100; y <= 100; ++y) {
    const float side = 0.02F * static_cast<float>(y);
    for (int z = 0; z <= 12; ++z)
      points.push_back({3.0F, side, kFloor + 0.1F * static_cast<float>(z), 50, 3, 0});
    for (int x = 10; x < 30; ++x) points.push_back({0.1F * static_cast<float>(x), side, kFloor, 10, 0, 0});
  }
  return points;
}

class CloudToScanTest : public testing::Test {
 protected:
  void load(const Params& params = {}) {
    ASSERT_TRUE(manager_.load("/cloud_to_scan", "cloud_to_scan", params)) << log_.text();
  }

  void load_and_connect(const Params& params = {}) {
    load(params);
    scans_.emplace("scan");
    nearest_.emplace("scan_nearest");
    ASSERT_TRUE(wait_for([this] { return cloud_.getNumSubscribers() > 0 && scans_->connected(); }));
  }

  /// Sends a cloud and returns its scan; null when none comes.
  sensor_msgs::LaserScanConstPtr flatten(const sensor_msgs::PointCloud2ConstPtr& cloud) {
    cloud_.publish(cloud);
    return scans_->wait_for_stamp(cloud->header.stamp);
  }

  void expect_error(const sensor_msgs::PointCloud2ConstPtr& cloud, const std::string& text) {
    cloud_.publish(cloud);
    EXPECT_TRUE(diagnostics_.wait([&](const Report& r) { return r.is_error_about(text); }))
        << text << "\n"
        << diagnostics_.latest().message();
  }

  /// The sensor stands on base_link.
  void publish_mount() {
    geometry_msgs::TransformStamped mount;
    mount.header.stamp = ros::Time(1, 0);
    mount.header.frame_id = "base_link";
    mount.child_frame_id = "velodyne";
    mount.transform.translation.z = kSensorHeightM;
    mount.transform.rotation.w = 1;
    broadcaster_.sendTransform(mount);
  }

  ros::NodeHandle handle_;
  ros::Publisher cloud_{handle_.advertise<sensor_msgs::PointCloud2>("velodyne_points", 10)};
  tf2_ros::StaticTransformBroadcaster broadcaster_;
  std::optional<Inbox<sensor_msgs::LaserScan>> scans_, nearest_;
  DiagnosticsWatch diagnostics_{"cloud_to_scan"};
  LogWatch log_;
  Manager manager_;
};

inline void expect_wall(const sensor_msgs::LaserScan& scan) {
  const auto ray = [&](double angle) {
    return scan.ranges.at(
        static_cast<std::size_t>(std::lround((angle - scan.angle_min) / scan.angle_increment)));
  };
  for (const double angle : {-0.5, -0.2, 0.0, 0.2, 0.5})
    EXPECT_NEAR(ray(angle), 3.0 / std::cos(angle), 0.02) << angle;
  EXPECT_TRUE(std::isnan(ray(2.0))) << "no beam there";
}

}  // namespace extperfc::ros_test
