// What the mapper publishes while all goes well.
#include <algorithm>
#include <cmath>
#include <set>

#include <extperfc/TrackArray.h>
#include <geometry_msgs/PoseArray.h>
#include <nav_msgs/GetMap.h>
#include <nav_msgs/MapMetaData.h>
#include <nav_msgs/Path.h>
#include <ros/service.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/MultiEchoLaserScan.h>
#include <std_msgs/Float64.h>

#include "ros/convert/planar_pose.hpp"
#include "test/ros/mapping/mapper_test.hpp"

namespace extperfc::ros_test {
namespace {

TEST_F(MapperTest, MapsTheRoomAndFollowsTheRobot) {
  mount_lidar();
  load();
  for (const auto& pose : round_trip()) {
    const auto found = feed(pose);
    ASSERT_TRUE(found) << diagnostics_.latest().message();
    EXPECT_LT(error_m(*found, pose), 0.06);
  }
  nav_msgs::GetMap call;
  ASSERT_TRUE(ros::service::call("dynamic_map", call));
  expect_map_of_the_room(call.response.map);
  EXPECT_EQ(call.response.map.header.frame_id, "map");
  EXPECT_EQ(call.response.map.header.stamp, now_);
  EXPECT_NEAR(static_cast<double>(call.response.map.info.resolution), 0.05, 1e-6);
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) {
    return r.level() == 0 && r.number("scans used") == 126 && r.number("key frames") > 10 &&
           r.value("scan transport") == "pointer (no copy)" && !r.value("effective particles").empty();
  })) << diagnostics_.latest().message();
}

TEST_F(MapperTest, DriftingOdometryIsCorrected) {
  mount_lidar();
  load();
  for (const auto& pose : round_trip()) {
    odom_T_room_ = compose(odom_T_room_, {0.002, 0.001, 0.002});  // 0.25 m and 14 degrees over the whole path
    const auto found = feed(pose);
    ASSERT_TRUE(found);
    EXPECT_LT(error_m(*found, pose), 0.08);
  }
  expect_map_of_the_room(map_now());
}

TEST_F(MapperTest, PeopleAreLeftOutOfTheMap) {
  mount_lidar();
  load();
  Track box;  // the one of the room, as if it were a person
  box.score = 1;
  box.size.x = 1.4;
  const Pose2 middle = compose(odom_T_room_, {1.7, 2.65, 0});
  box.pose.pose.position.x = middle.x;
  box.pose.pose.position.y = middle.y;
  TrackArray people;
  people.header.frame_id = "odom";
  people.header.stamp = now_;
  people.tracks.push_back(box);
  auto publisher = handle_.advertise<TrackArray>("people_tracks", 1, true);
  publisher.publish(people);
  ASSERT_TRUE(wait_for([&] { return publisher.getNumSubscribers() > 0; }));
  ASSERT_TRUE(drive(straight_path({0, 0, 0}, {0.3, 0, 0}, 6)));
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) {
    return r.number("returns of people left out") > 50;
  })) << diagnostics_.latest().message();
}

TEST_F(MapperTest, TheMapFrameJoinsMapAndOdometry) {
  mount_lidar();
  load();
  ASSERT_TRUE(drive(straight_path({0, 0, 0}, {1, 0.2, 0.3}, 10)));
  const Pose2 here{1.1, 0.2, 0.4};
  const auto pose = feed(here);
  ASSERT_TRUE(pose);
  const auto joins = [&] {
    const auto transform = last_transform("odom");
    if (!transform) return false;
    const auto found =
        compose(ros_convert::to_pose2(transform->transform).value(), compose(odom_T_room_, here));
    return std::hypot(found.x - pose->x, found.y - pose->y) < 1e-6 &&
           std::abs(wrap_angle(found.yaw - pose->yaw)) < 1e-6;
  };
  EXPECT_TRUE(wait_for(joins));
}

TEST_F(MapperTest, TheMapFrameIsPublishedWhileTheLidarIsSilent) {
  mount_lidar();
  load({{"transform_publish_period", 0.02}, {"tf_delay", 0.3}});
  ASSERT_TRUE(feed({0, 0, 0}));
  ASSERT_TRUE(wait_for([this] { return last_transform("odom").has_value(); }));
  transforms_.clear();
  ASSERT_TRUE(wait_for([this] { return transforms_.count() >= 10; }));
  ros::Time before;
  for (const auto& message : transforms_.all())
    for (const auto& transform : message->transforms) {
      EXPECT_GT(transform.header.stamp, before) << "tf warns of the same stamp twice";
      before = transform.header.stamp;
    }
  const auto ahead = [this] {
    return last_transform("odom")->header.stamp - ros::Time::now() > ros::Duration(0.2);
  };
  EXPECT_TRUE(wait_for(ahead)) << "stamped ahead by tf_delay";
}

TEST_F(MapperTest, NoTransformsWhenThePeriodIsZero) {
  mount_lidar();
  load({{"transform_publish_period", 0}});
  ASSERT_TRUE(feed({0, 0, 0}));
  EXPECT_TRUE(never([this] { return last_transform("odom").has_value(); }, 0.3));
}

TEST_F(MapperTest, FramesAreParameters) {
  mount_lidar();
  load({{"map_frame", "/floor"}});
  ASSERT_TRUE(feed({0, 0, 0}));
  ASSERT_TRUE(map());
  EXPECT_EQ(map()->header.frame_id, "floor");
  EXPECT_EQ(poses_.all().back()->header.frame_id, "floor");
}

TEST_F(MapperTest, TheMapIsLatchedWithItsMetadata) {
  mount_lidar();
  load();
  ASSERT_TRUE(drive(straight_path({0, 0, 0}, {1, 0, 0}, 10)));
  ASSERT_TRUE(wait_for([this] { return map()->header.stamp == now_; }) || map());
  const Inbox<nav_msgs::OccupancyGrid> late_map("map");
  const Inbox<nav_msgs::MapMetaData> late_metadata("map_metadata");
  ASSERT_TRUE(late_map.wait_for_count(1));
  ASSERT_TRUE(late_metadata.wait_for_count(1));
  const auto info = late_map.all().back()->info;
  EXPECT_EQ(info.width * info.height, late_map.all().back()->data.size());
  EXPECT_TRUE(wait_for([&] { return late_metadata.all().back()->width == info.width; }));
}

TEST_F(MapperTest, AMapLeavesOnlyWhenItHasChanged) {
  mount_lidar();
  load();
  ASSERT_TRUE(drive(straight_path({0, 0, 0}, {1, 0, 0}, 10)));
  ASSERT_TRUE(map());
  std::size_t settled = 0;
  ASSERT_TRUE(wait_for([&] {
    const auto before = settled;
    settled = maps_.count();
    (void)never([] { return false; }, 0.4);
    return maps_.count() == before;
  }));
  EXPECT_TRUE(never([&] { return maps_.count() > settled; }));
}

TEST_F(MapperTest, MapsLeaveAtABoundedRate) {
  mount_lidar();
  load({{"map_update_interval", 0.5}});
  const auto begin = ros::WallTime::now();
  ASSERT_TRUE(drive(round_trip()));
  const double passed_s = (ros::WallTime::now() - begin).toSec();
  EXPECT_LE(static_cast<double>(maps_.count()), 2.0 + passed_s / 0.5);
  EXPECT_GE(maps_.count(), 1U);
}

TEST_F(MapperTest, ParticlesAndEntropy) {
  mount_lidar();
  const Inbox<geometry_msgs::PoseArray> clouds("particlecloud");
  const Inbox<std_msgs::Float64> entropies("mapper/entropy");
  load({{"particles", 7}});
  ASSERT_TRUE(wait_for([&] { return clouds.connected() && entropies.connected(); }));
  ASSERT_TRUE(drive(straight_path({0, 0, 0}, {1.5, 0, 0}, 15)));
  ASSERT_TRUE(clouds.wait_for_count(1));
  EXPECT_EQ(clouds.all().back()->poses.size(), 7U);
  EXPECT_EQ(clouds.all().back()->header.frame_id, "map");
  ASSERT_TRUE(entropies.wait_for_count(1));
  EXPECT_GE(entropies.all().back()->data, 0.0);
  EXPECT_LE(entropies.all().back()->data, std::log(7.0) + 1e-9);
}

TEST_F(MapperTest, TheTrajectoryHasEveryScan) {
  mount_lidar();
  load({{"trajectory_interval_s", 0.05}});
  ASSERT_TRUE(drive(straight_path({0, 0, 0}, {1, 0, 0}, 10)));
  const Inbox<nav_msgs::Path> paths("trajectory");
  ASSERT_TRUE(wait_for([&] { return paths.count() > 0 && paths.all().back()->poses.size() == 10; }));
  const auto last = *paths.all().back();
  EXPECT_EQ(last.header.frame_id, "map");
  EXPECT_NEAR(last.poses.back().header.stamp.toSec(), now_.toSec(), 1e-3);
}

TEST_F(MapperTest, ThePoseHasACovariance) {
  mount_lidar();
  load();
  ASSERT_TRUE(drive(straight_path({0, 0, 0}, {1, 0, 0}, 10)));
  const auto& covariance = poses_.all().back()->pose.covariance;
  for (const std::size_t diagonal : {0U, 7U, 35U}) {
    EXPECT_GT(covariance[diagonal], 0.0);
    EXPECT_LT(covariance[diagonal], 0.1);
  }
}

TEST_F(MapperTest, AScannerThatHangsUpsideDown) {
  mount_lidar(M_PI);
  load();
  for (const auto& pose : round_trip()) {
    const auto found = feed(pose);
    ASSERT_TRUE(found) << diagnostics_.latest().message();
    EXPECT_LT(error_m(*found, pose), 0.06);
  }
  expect_map_of_the_room(map_now());
}

TEST_F(MapperTest, EveryThirdScan) {
  mount_lidar();
  load({{"throttle_scans", 3}});
  for (int i = 0; i < 9; ++i) {
    publish_odometry(odom_T_room_, now_ + ros::Duration(kPeriodS));
    send_scan({0, 0, 0});
  }
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) {
    return r.number("scans used") == 3 && r.number("scans skipped by throttle_scans") == 6;
  })) << diagnostics_.latest().message();
}

TEST_F(MapperTest, MultiEchoScans) {
  mount_lidar();
  scans_.shutdown();
  auto echoes = handle_.advertise<sensor_msgs::MultiEchoLaserScan>("scan", 10);
  ASSERT_TRUE(manager_.load("/mapper", "mapper", {{"multi_echo", true}, {"odometry", "none"}}))
      << log_.text();
  ASSERT_TRUE(wait_for([&] { return echoes.getNumSubscribers() > 0 && poses_.connected(); }));
  const auto stamp = tick();
  const auto single = scan_message(base_T_laser_, stamp);
  sensor_msgs::MultiEchoLaserScan message;
  message.header = single->header;
  message.angle_min = single->angle_min;
  message.angle_increment = single->angle_increment;
  message.range_min = single->range_min;
  message.range_max = single->range_max;
  for (const float range : single->ranges) {
    sensor_msgs::LaserEcho echo;
    echo.echoes = {0.5F * range, range};
    message.ranges.push_back(echo);
    echo.echoes = {10, 100};
    message.intensities.push_back(echo);
  }
  echoes.publish(message);
  first_in_map_ = answer_at(stamp);
  ASSERT_TRUE(first_in_map_);
  first_in_room_ = Pose2{};
  nav_msgs::GetMap call;
  ASSERT_TRUE(ros::service::call("dynamic_map", call));
  const auto room_T_map = inverse(*first_in_map_);
  std::size_t occupied = 0;
  for (std::size_t i = 0; i < call.response.map.data.size(); ++i) {
    if (call.response.map.data[i] < 65) continue;
    const auto& info = call.response.map.info;
    const double side = static_cast<double>(info.resolution);
    const auto place =
        compose(room_T_map, {info.origin.position.x + (static_cast<double>(i % info.width) + 0.5) * side,
                             info.origin.position.y + (static_cast<double>(i / info.width) + 0.5) * side, 0});
    EXPECT_LT(distance_to_wall(place.x, place.y), 0.15) << "the stronger echo is the wall";
    ++occupied;
  }
  EXPECT_GT(occupied, 100U);
}

TEST_F(MapperTest, RotationByTheImu) {
  mount_lidar();
  auto imu = handle_.advertise<sensor_msgs::Imu>("imu", 100);
  load({{"use_imu", true}, {"transform_timeout_s", 1.0}});
  ASSERT_TRUE(wait_for([&] { return imu.getNumSubscribers() > 0; }));
  const auto send = [&](const ros::Time& stamp, double yaw_rad) {
    sensor_msgs::Imu message;
    message.header.frame_id = "base_link";
    message.header.stamp = stamp;
    message.orientation = ros_convert::to_pose_message({0, 0, yaw_rad + 0.7}).orientation;
    imu.publish(message);
  };
  send(now_, 0);  // a scan does not wait for an IMU that has never been heard
  ASSERT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.number("imu received") == 1; }));
  for (const auto& pose : round_trip()) {
    send(now_ + ros::Duration(kPeriodS), pose.yaw);
    // Wheels that slip: odometry believes in half a degree too much, every time.
    odom_T_room_ = compose(odom_T_room_, {0, 0, 0.01});
    const auto found = feed(pose);
    ASSERT_TRUE(found);
    EXPECT_LT(error_m(*found, pose), 0.08);
  }
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.number("imu received") == 127; }));
  EXPECT_EQ(diagnostics_.latest().number("scans without imu"), 0);
  ASSERT_TRUE(feed({0, 0, 0})) << "an IMU that stops is no reason to stop";
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.is_warning_about("no IMU reading"); }));
}

}  // namespace
}  // namespace extperfc::ros_test
