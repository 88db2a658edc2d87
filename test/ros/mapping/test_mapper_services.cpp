// Saving, resuming, pausing, restarting.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include <nav_msgs/GetMap.h>
#include <ros/service.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include "extperfc/LoadSession.h"
#include "extperfc/SaveMap.h"
#include "extperfc/sources/mrpt_map.hpp"
#include "extperfc/world/map_file.hpp"

#include "test/ros/mapping/mapper_test.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::ros_test {
namespace {

namespace fs = std::filesystem;

std_srvs::Trigger::Response trigger(const std::string& name) {
  std_srvs::Trigger call;
  EXPECT_TRUE(ros::service::call("/mapper/" + name, call)) << name;
  return call.response;
}

std_srvs::SetBool::Response set_localization(bool on) {
  std_srvs::SetBool call;
  call.request.data = static_cast<unsigned char>(on);
  EXPECT_TRUE(ros::service::call("/mapper/set_localization", call));
  return call.response;
}

SaveMap::Response save(const fs::path& path) {
  SaveMap call;
  call.request.path = path.string();
  EXPECT_TRUE(ros::service::call("/mapper/save_map", call));
  return call.response;
}

LoadSession::Response load_session(const fs::path& path) {
  LoadSession call;
  call.request.path = path.string();
  EXPECT_TRUE(ros::service::call("/mapper/load_session", call));
  return call.response;
}

/// Fraction of the cells of `a` that are equal in `b`, where both are known.
double agreement(const nav_msgs::OccupancyGrid& a, const OccupancyGrid& b) {
  const double side = static_cast<double>(a.info.resolution);
  std::size_t both = 0;
  std::size_t equal = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) {
    if (a.data[i] < 0) continue;
    const auto cell =
        b.cell_of(a.info.origin.position.x + (static_cast<double>(i % a.info.width) + 0.5) * side,
                  a.info.origin.position.y + (static_cast<double>(i / a.info.width) + 0.5) * side);
    if (!cell || b.at(cell->column, cell->row) < 0) continue;
    ++both;
    equal += (a.data[i] >= 65) == (b.at(cell->column, cell->row) >= 65);
  }
  return both == 0 ? 0.0 : static_cast<double>(equal) / static_cast<double>(both);
}

class MapperServicesTest : public MapperTest {
 protected:
  [[nodiscard]] fs::path stem() const { return folder_.path() / "office"; }

  /// Maps a part of the room.
  void load_and_drive(const Params& more = {}) {
    mount_lidar();
    load(more);
    ASSERT_TRUE(drive(straight_path({0, 0, 0}, {2, -0.5, 0.5}, 20)));
  }

  TemporaryFolder folder_;
};

TEST_F(MapperServicesTest, SavesWhatMapServerReads) {
  load_and_drive();
  const auto saved = save(stem());
  ASSERT_TRUE(saved.success) << saved.message;
  for (const char* suffix : {".pgm", ".yaml", ".session"}) {
    EXPECT_GT(fs::file_size(stem().string() + suffix), 20U) << suffix;
    EXPECT_NE(saved.message.find(suffix), std::string::npos) << saved.message;
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 3)
      << "nothing unfinished stays";
  const auto loaded = load_map(stem().string() + ".yaml");
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_GT(agreement(map_now(), *loaded), 0.99);
}

TEST_F(MapperServicesTest, OptimizesOnDemand) {
  mount_lidar();
  load();
  EXPECT_FALSE(trigger("optimize").success) << "there is no map yet";
  ASSERT_TRUE(drive(straight_path({0, 0, 0}, {2, -0.5, 0.5}, 20)));
  const auto answer = trigger("optimize");
  EXPECT_TRUE(answer.success) << answer.message;
  EXPECT_NE(answer.message.find("key frames"), std::string::npos) << answer.message;
  const auto found = feed({2, -0.5, 0.5});
  ASSERT_TRUE(found) << "mapping continues";
  EXPECT_LT(error_m(*found, {2, -0.5, 0.5}), 0.1);
}

TEST_F(MapperServicesTest, SavesWhatMrptReads) {
  load_and_drive();
  const auto file = folder_.path() / "office.gridmap.gz";
  const auto saved = save(file);
  if (saved.message.find("without MRPT") != std::string::npos) GTEST_SKIP() << saved.message;
  ASSERT_TRUE(saved.success) << saved.message;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 1)
      << "the grid map and nothing else";
  const auto loaded = sources::load_gridmap(file);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_GT(agreement(map_now(), *loaded), 0.99);
}

TEST_F(MapperServicesTest, WhatCannotBeSavedIsNamed) {
  mount_lidar();
  load();
  EXPECT_NE(save(stem()).message.find("there is no map yet"), std::string::npos);
  ASSERT_TRUE(feed({0, 0, 0}));
  EXPECT_NE(save("").message.find("path must name a file"), std::string::npos);
  const auto nowhere = save("/no/such/folder/office");
  EXPECT_FALSE(nowhere.success);
  EXPECT_NE(nowhere.message.find("/no/such/folder/office"), std::string::npos) << nowhere.message;
  ASSERT_TRUE(feed({0, 0, 0})) << "mapping continues";
}

TEST_F(MapperServicesTest, GoesOnWithASavedSession) {
  load_and_drive();
  ASSERT_TRUE(save(stem()).success);
  const auto before = map_now();
  ASSERT_TRUE(trigger("reset").success);
  maps_.clear();
  const auto answer = load_session(stem().string() + ".session");
  ASSERT_TRUE(answer.success) << answer.message;
  ASSERT_TRUE(maps_.wait_for_count(1)) << "the map is there at once";
  odom_T_room_ = {10, 10, -1};  // a robot that was switched off meanwhile
  for (const auto& pose : straight_path({2, -0.5, 0.5}, {3, 1.5, 1.5}, 20)) {
    const auto found = feed(pose);
    ASSERT_TRUE(found) << diagnostics_.latest().message();
    EXPECT_LT(error_m(*found, pose), 0.1);
  }
  const auto after = map_now();
  EXPECT_GE(after.data.size(), before.data.size());
}

TEST_F(MapperServicesTest, ASessionAsAParameter) {
  load_and_drive();
  ASSERT_TRUE(save(stem()).success);
  manager_.unload("/mapper");
  load({{"session", stem().string() + ".session"}});
  const auto found = feed({2, -0.5, 0.5});
  ASSERT_TRUE(found);
  EXPECT_LT(error_m(*found, {2, -0.5, 0.5}), 0.1);
}

TEST_F(MapperServicesTest, ARobotThatWasCarriedIsPutWhereItStands) {
  load_and_drive();
  auto initial_poses = handle_.advertise<geometry_msgs::PoseWithCovarianceStamped>("initialpose", 5);
  ASSERT_TRUE(wait_for([&] { return initial_poses.getNumSubscribers() > 0; }));
  geometry_msgs::PoseWithCovarianceStamped message;
  const Pose2 put_down{-2, 2, 2.5};
  const Pose2 in_map = compose(*first_in_map_, between(*first_in_room_, put_down));
  const Pose2 guess = compose(in_map, {0.3, -0.3, 0.2});
  message.header.frame_id = "map";
  message.pose.pose.position.x = guess.x;
  message.pose.pose.position.y = guess.y;
  message.pose.pose.orientation.z = std::sin(guess.yaw / 2);
  message.pose.pose.orientation.w = std::cos(guess.yaw / 2);
  initial_poses.publish(message);
  message.header.frame_id = "odom";
  initial_poses.publish(message);
  ASSERT_TRUE(log_.wait("ignoring initial pose: its frame is 'odom', not 'map'"))
      << "the one before was used";
  odom_T_room_ = compose(compose(odom_T_room_, {2, -0.5, 0.5}), inverse(put_down));  // the wheels saw nothing
  for (const auto& pose : straight_path(put_down, {-1, 2.5, 2}, 8)) {
    const auto found = feed(pose);
    ASSERT_TRUE(found);
    EXPECT_LT(error_m(*found, pose), 0.15);
  }
}

TEST_F(MapperServicesTest, ASessionThatCannotBeReadChangesNothing) {
  load_and_drive();
  const auto before = map_now();
  const auto missing = load_session(folder_.path() / "none.session");
  EXPECT_FALSE(missing.success);
  EXPECT_NE(missing.message.find("none.session"), std::string::npos) << missing.message;
  const auto garbage =
      load_session(folder_.write("garbage.session", "This is no session, whatever it says."));
  EXPECT_FALSE(garbage.success);
  EXPECT_NE(garbage.message.find("garbage.session"), std::string::npos) << garbage.message;
  EXPECT_FALSE(load_session("").success);
  EXPECT_EQ(map_now().data, before.data);
  EXPECT_FALSE(manager_.load("/other", "mapper", {{"session", "/no/such.session"}}));
  EXPECT_TRUE(log_.wait("/no/such.session"));
}

TEST_F(MapperServicesTest, PausesAndResumes) {
  load_and_drive();
  ASSERT_TRUE(trigger("pause").success);
  const auto used = poses_.count();
  const auto before = map_now();
  for (const auto& pose : straight_path({2, -0.5, 0.5}, {2.2, -0.5, 0.5}, 4)) {
    publish_odometry(compose(odom_T_room_, pose), now_ + ros::Duration(kPeriodS));
    send_scan(pose);
  }
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) {
    return r.is_warning_about("paused") && r.number("scans skipped while paused") == 4;
  })) << diagnostics_.latest().message();
  EXPECT_EQ(poses_.count(), used);
  EXPECT_EQ(map_now().data, before.data);
  transforms_.clear();
  EXPECT_TRUE(wait_for([this] { return last_transform("odom").has_value(); })) << "tf continues";
  ASSERT_TRUE(trigger("resume").success);
  const auto found = feed({2.3, -0.5, 0.5});
  ASSERT_TRUE(found);
  EXPECT_LT(error_m(*found, {2.3, -0.5, 0.5}), 0.1);
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.level() == 0; }));
}

TEST_F(MapperServicesTest, LocalizesInItsMapAndMapsAgain) {
  mount_lidar();
  load();
  EXPECT_FALSE(set_localization(true).success) << "there is no map yet";
  ASSERT_TRUE(drive(straight_path({0, 0, 0}, {2, -0.5, 0.5}, 20)));
  const auto before = map_now();
  ASSERT_TRUE(set_localization(true).success);
  for (const auto& pose : straight_path({2, -0.5, 0.5}, {0.3, 0.4, 0.2}, 12)) {
    const auto found = feed(pose);
    ASSERT_TRUE(found);
    EXPECT_LT(error_m(*found, pose), 0.06);
  }
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) {
    return r.value("state") == "localizing" && r.level() == 0;
  })) << diagnostics_.latest().message();
  EXPECT_EQ(map_now().data, before.data);
  ASSERT_TRUE(set_localization(false).success);
  for (const auto& pose : straight_path({0.3, 0.4, 0.2}, {-1.5, 0.4, 0.2}, 12)) {
    const auto found = feed(pose);
    ASSERT_TRUE(found);
    EXPECT_LT(error_m(*found, pose), 0.1);
  }
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.value("state") == "mapping"; }));
  EXPECT_NE(map_now().data, before.data);
}

TEST_F(MapperServicesTest, LocalizesInASessionFromTheStart) {
  load_and_drive();
  ASSERT_TRUE(save(stem()).success);
  manager_.unload("/mapper");
  EXPECT_FALSE(manager_.load("/other", "mapper", {{"localization", true}})) << "without a session";
  load({{"session", stem().string() + ".session"}, {"localization", true}});
  const auto found = feed({2, -0.5, 0.5});
  ASSERT_TRUE(found);
  EXPECT_LT(error_m(*found, {2, -0.5, 0.5}), 0.1);
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.value("state") == "localizing"; }));
}

TEST_F(MapperServicesTest, BeginsAnew) {
  load_and_drive();
  ASSERT_TRUE(trigger("reset").success);
  nav_msgs::GetMap call;
  EXPECT_FALSE(ros::service::call("dynamic_map", call)) << "there is no map until the next scan";
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.number("key frames") == 0; }));
  first_in_map_.reset();
  for (const auto& pose : round_trip()) {
    const auto found = feed(pose);
    ASSERT_TRUE(found);
    EXPECT_LT(error_m(*found, pose), 0.06);
  }
  expect_map_of_the_room(map_now());
}

TEST_F(MapperServicesTest, NoMapBeforeTheFirstScan) {
  mount_lidar();
  load();
  nav_msgs::GetMap call;
  EXPECT_FALSE(ros::service::call("dynamic_map", call));
  EXPECT_EQ(maps_.count(), 0U);
}

/// A hall of 190 x 190 m, as a lidar in its middle sees it.
sensor_msgs::LaserScanPtr hall_scan(double x_m, const ros::Time& stamp) {
  auto message = scan_message({}, stamp);
  message->range_max = 200;
  for (std::size_t i = 0; i < message->ranges.size(); ++i) {
    const double angle = static_cast<double>(message->angle_min) + static_cast<double>(i) * M_PI / 180;
    const double along =
        (std::cos(angle) > 0 ? 95.0 - x_m : 95.0 + x_m) / std::max(1e-9, std::abs(std::cos(angle)));
    message->ranges[i] =
        static_cast<float>(std::min(along, 95.0 / std::max(1e-9, std::abs(std::sin(angle)))));
  }
  return message;
}

TEST_F(MapperServicesTest, ALargeMapIsPublishedBesideTheWorker) {
  base_T_laser_ = {};
  mount_lidar();
  load();
  for (int i = 0; i < 20; ++i) {
    const auto stamp = tick();
    publish_odometry(compose(odom_T_room_, {0.1 * i, 0, 0}), stamp);
    scans_.publish(hall_scan(0.1 * i, stamp));
    ASSERT_TRUE(answer_at(stamp));
  }
  EXPECT_TRUE(wait_for([this] { return maps_.count() > 1 && maps_.all().back()->info.width >= 3800; }));
  EXPECT_TRUE(
      diagnostics_.wait_latest([](const Report& r) { return r.value("map size [cells]") == "3840 x 3840"; }));
  const auto report = diagnostics_.latest();
  std::printf("%s: held the mapper %s ms, at most %s ms; built and sent in %s ms\n",
              report.value("map size [cells]").c_str(), report.value("map held the mapper [ms]").c_str(),
              report.value("map held the mapper at most [ms]").c_str(),
              report.value("map built and sent [ms]").c_str());
}

}  // namespace
}  // namespace extperfc::ros_test
