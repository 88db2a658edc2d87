// The nodelet as a lidar's driver and a planner see it.
#include <cmath>

#include <gtest/gtest.h>
#include <ros/package.h>
#include <ros/param.h>
#include <yaml-cpp/yaml.h>

#include "ros/params/cloud_to_scan_params.hpp"
#include "test/ros/scan/cloud_to_scan_test.hpp"
#include "test/ros/support/simulated_time.hpp"

namespace extperfc::ros_test {
namespace {

TEST_F(CloudToScanTest, AWallWithoutTheFloorBeforeIt) {
  publish_mount();
  for (const char* method : {"height", "plane"}) {
    load_and_connect({{"target_frame", "base_link"},
                      {"transform_tolerance", 5.0},
                      {"ground_method", method},
                      {"min_height", -0.2}});
    const auto scan = flatten(cloud_message(wall_and_floor(), ros::Time(2, 0)));
    ASSERT_TRUE(scan) << diagnostics_.latest().message();
    EXPECT_EQ(scan->header.frame_id, "base_link");
    EXPECT_FLOAT_EQ(scan->scan_time, 0.1F);
    EXPECT_EQ(scan->ranges.size(), 720U);
    EXPECT_EQ(scan->intensities.size(), 720U);
    expect_wall(*scan);
    EXPECT_TRUE(diagnostics_.wait([](const Report& r) {
      return r.level() == 0 && r.number("points on the ground") > 201 * 20 && r.number("points used") > 1000;
    })) << method;
    manager_.unload("/cloud_to_scan");
    scans_.reset();
    nearest_.reset();
    diagnostics_.forget();
  }
}

TEST_F(CloudToScanTest, InTheCloudsOwnFrame) {
  load_and_connect({{"min_height", -0.5}, {"max_height", 0.3}, {"ground_method", "none"}});
  const auto scan = flatten(cloud_message(wall_and_floor(), ros::Time(2, 0)));
  ASSERT_TRUE(scan) << diagnostics_.latest().message();
  EXPECT_EQ(scan->header.frame_id, "velodyne");
  expect_wall(*scan);
}

TEST_F(CloudToScanTest, SelectedRingsOnly) {
  load_and_connect({{"min_height", -2.0}, {"ground_method", "none"}, {"rings", "0"}});
  const auto scan = flatten(cloud_message(wall_and_floor(), ros::Time(2, 0)));
  ASSERT_TRUE(scan);
  EXPECT_LT(scan->ranges[360], 1.5) << "the floor, not the wall";
}

TEST_F(CloudToScanTest, SubscribesOnlyWhileSomebodyListensToOneOfTheScans) {
  load();
  EXPECT_TRUE(never([this] { return cloud_.getNumSubscribers() > 0; }));
  for (const char* topic : {"scan", "scan_nearest"}) {
    scans_.emplace(topic);
    EXPECT_TRUE(wait_for([this] { return cloud_.getNumSubscribers() == 1; })) << topic;
    scans_.reset();
    EXPECT_TRUE(wait_for([this] { return cloud_.getNumSubscribers() == 0; })) << topic;
  }
}

TEST_F(CloudToScanTest, CloudsTravelAsPointers) {
  load_and_connect();
  const auto cloud = cloud_message(wall_and_floor(), ros::Time(2, 0));
  ASSERT_TRUE(flatten(cloud));
  EXPECT_TRUE(
      diagnostics_.wait([](const Report& r) { return r.value("cloud transport") == "pointer (no copy)"; }));
  const auto addresses = diagnostics_.addresses("cloud last");
  EXPECT_EQ(addresses.at(stamp_text(cloud->header.stamp)), address_text(cloud->data.data()));
}

TEST_F(CloudToScanTest, AnEmptyCloudGivesAnEmptyScan) {
  load_and_connect();
  const auto scan = flatten(cloud_message({}, ros::Time(2, 0)));
  ASSERT_TRUE(scan);
  EXPECT_EQ(scan->ranges.size(), 720U);
  for (const float range : scan->ranges) EXPECT_TRUE(std::isnan(range));
}

TEST_F(CloudToScanTest, WhatCannotBeUsedIsAnErrorUntilItWorksAgain) {
  load_and_connect({{"rings", "3"}});
  const auto no_rings = cloud_message(wall_and_floor(), ros::Time(2, 0));
  no_rings->fields.resize(4);
  expect_error(no_rings, "no field 'ring'");
  const auto no_z = cloud_message(wall_and_floor(), ros::Time(3, 0));
  no_z->fields[2].name = "height";
  expect_error(no_z, "no field 'z'; its fields: x, y, height, intensity, ring");
  const auto cut = cloud_message(wall_and_floor(), ros::Time(4, 0));
  cut->data.resize(cut->data.size() / 2);
  expect_error(cut, "bytes of data");
  ASSERT_TRUE(flatten(cloud_message(wall_and_floor(), ros::Time(5, 0))));
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.level() == 0; }));
}

TEST_F(CloudToScanTest, AMissingTransformIsNamed) {
  load_and_connect({{"target_frame", "nowhere"}, {"transform_tolerance", 0.0}});
  expect_error(cloud_message(wall_and_floor(), ros::Time(2, 0)), "no transform from velodyne to nowhere");
}

TEST_F(CloudToScanTest, NoGroundPlaneIsAWarning) {
  load_and_connect({{"ground_method", "plane"}, {"ground_z_m", 5.0}});
  ASSERT_TRUE(flatten(cloud_message(wall_and_floor(), ros::Time(2, 0))));
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.is_warning_about("no ground plane found"); }));
}

TEST_F(CloudToScanTest, DiagnosticsGoOnAfterTheClockRanBack) {
  load();
  ASSERT_TRUE(diagnostics_.goes_on());
  const SimulatedTime earlier(10.0);
  EXPECT_TRUE(diagnostics_.goes_on()) << "not only when the time of before is reached";
}

TEST_F(CloudToScanTest, UnloadsWhileCloudsCome) {
  load_and_connect({{"target_frame", "nowhere"}, {"transform_tolerance", 5.0}});
  for (unsigned i = 1; i <= 20; ++i) cloud_.publish(cloud_message(wall_and_floor(), ros::Time(i, 0)));
  const auto before = ros::WallTime::now();
  manager_.unload("/cloud_to_scan");
  EXPECT_LT((ros::WallTime::now() - before).toSec(), 4.0) << "it must not wait for the transform";
}

TEST_F(CloudToScanTest, BadParametersAreRefusedAllAtOnce) {
  EXPECT_FALSE(manager_.load(
      "/cloud_to_scan", "cloud_to_scan",
      {{"angle_increment", 0.0}, {"rings", "a"}, {"ground_method", "ransac"}, {"min_hight", 0.1}}));
  ASSERT_TRUE(log_.wait("angle_increment"));
  for (const char* text : {"angle_increment = 0 is out of its range", "rings: 'a' is not a list",
                           "unknown ground_method 'ransac'", "min_hight is not a parameter"})
    EXPECT_NE(log_.text().find(text), std::string::npos) << text << "\n" << log_.text();
}

TEST(CloudToScanParams, ShippedConfigurationHasTheDefaults) {
  const std::string ns = "/cloud_to_scan_under_test";
  const auto defaults = ros_params::load_cloud_to_scan_params(ros::NodeHandle(ns));
  for (const auto& entry : YAML::LoadFile(ros::package::getPath("extperfc") + "/config/cloud_to_scan.yaml")) {
    const auto key = ns + "/" + entry.first.as<std::string>();
    double number = 0;
    bool flag = false;
    if (entry.second.Tag() != "!" && YAML::convert<double>::decode(entry.second, number))
      ros::param::set(
          key, std::floor(number) == number && entry.second.as<std::string>().find('.') == std::string::npos
                   ? XmlRpc::XmlRpcValue(static_cast<int>(number))
                   : XmlRpc::XmlRpcValue(number));
    else if (entry.second.Tag() != "!" && YAML::convert<bool>::decode(entry.second, flag))
      ros::param::set(key, flag);
    else
      ros::param::set(key, entry.second.as<std::string>());
  }
  const auto shipped = ros_params::load_cloud_to_scan_params(ros::NodeHandle(ns));
  (void)ros::param::del(ns);
  ASSERT_TRUE(defaults && shipped) << shipped.error().message;
  const auto& a = defaults->scan;
  const auto& b = shipped->scan;
  EXPECT_EQ(a.min_height, b.min_height);
  EXPECT_EQ(a.max_height, b.max_height);
  EXPECT_NEAR(a.angle_min, b.angle_min, 1e-7);
  EXPECT_NEAR(a.angle_max, b.angle_max, 1e-7);
  EXPECT_NEAR(a.angle_increment, b.angle_increment, 1e-7);
  EXPECT_EQ(a.range_min, b.range_min);
  EXPECT_EQ(a.range_max, b.range_max);
  EXPECT_EQ(a.use_inf, b.use_inf);
  EXPECT_EQ(a.inf_epsilon, b.inf_epsilon);
  EXPECT_EQ(a.intensity, b.intensity);
  EXPECT_EQ(a.rings.has_value(), b.rings.has_value());
  EXPECT_EQ(a.ground.method, b.ground.method);
  EXPECT_EQ(a.ground.z_m, b.ground.z_m);
  EXPECT_EQ(a.ground.clearance_m, b.ground.clearance_m);
  EXPECT_EQ(a.ground.band_m, b.ground.band_m);
  EXPECT_EQ(a.ground.max_slope_rad, b.ground.max_slope_rad);
  EXPECT_EQ(a.ground.inlier_m, b.ground.inlier_m);
  EXPECT_EQ(a.ground.max_iterations, b.ground.max_iterations);
  EXPECT_EQ(a.ground.min_points, b.ground.min_points);
  EXPECT_EQ(a.ground.seed, b.ground.seed);
  EXPECT_EQ(defaults->transform_tolerance, shipped->transform_tolerance);
  EXPECT_EQ(a.scan_time, b.scan_time);
  EXPECT_EQ(a.support_m, b.support_m);
  EXPECT_EQ(a.range_noise_m, b.range_noise_m);
  EXPECT_EQ(a.no_return_range, b.no_return_range);
  EXPECT_EQ(a.azimuth_times, b.azimuth_times);
  EXPECT_EQ(defaults->level, shipped->level);
  EXPECT_EQ(defaults->deskew, shipped->deskew);
  EXPECT_EQ(defaults->self_padding, shipped->self_padding);
  EXPECT_EQ(defaults->timeout_s, shipped->timeout_s);
}

}  // namespace
}  // namespace extperfc::ros_test
