// The map server as a nodelet and as a program: map_server's interface, and floors by name.
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>
#include <nav_msgs/GetMap.h>
#include <nav_msgs/LoadMap.h>
#include <nav_msgs/MapMetaData.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/service.h>

#include "extperfc/world/map_file.hpp"

#include "test/ros/support/child_process.hpp"
#include "test/ros/support/inbox.hpp"
#include "test/ros/support/manager.hpp"
#include "test/ros/support/watch.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::ros_test {
namespace {

using nav_msgs::LoadMap;

/// The program lies beside this one.
std::string program_path() {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "map_server").string();
}

class MapServerTest : public testing::Test {
 protected:
  MapServerTest() {
    EXPECT_TRUE(save_map(ground_, folder_.path() / "ground"));
    EXPECT_TRUE(
        save_map({1, 1, 0.1, {}, {100}}, folder_.path() / "first", {}, {MapImage::kPng, MapMode::kTrinary}));
    folder_.write("floors.yaml",
                  "floors:\n- {name: ground, map: ground.yaml}\n- {name: first, map: first.yaml}\n");
  }

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  [[nodiscard]] LoadMap::Response change(const std::string& map) const {
    LoadMap call;
    call.request.map_url = map;
    EXPECT_TRUE(ros::service::waitForService("change_map", ros::Duration(kPatienceS)));
    EXPECT_TRUE(ros::service::call("change_map", call)) << log_.text();
    return call.response;
  }

  TemporaryFolder folder_;
  OccupancyGrid ground_{3, 2, 0.05, {-1, 2.5, 0.5}, {0, 100, -1, 0, 0, 100}};
  Inbox<nav_msgs::OccupancyGrid> maps_{"map"};
  Inbox<nav_msgs::MapMetaData> metadata_{"map_metadata"};
  DiagnosticsWatch diagnostics_{"map_server"};
  LogWatch log_;
  Manager manager_;
};

TEST_F(MapServerTest, OneMapFromAFile) {
  ASSERT_TRUE(
      manager_.load("/map_server", "map_server", {{"map_file", path("ground.yaml")}, {"frame_id", "floor"}}))
      << log_.text();
  ASSERT_TRUE(maps_.wait_for_count(1) && metadata_.wait_for_count(1));
  const auto map = maps_.all().back();
  EXPECT_EQ(map->header.frame_id, "floor");
  EXPECT_EQ(map->data, ground_.cells);
  EXPECT_EQ(map->info.width, 3U);
  EXPECT_NEAR(map->info.origin.position.y, 2.5, 1e-9);
  EXPECT_NEAR(map->info.origin.orientation.z, std::sin(0.25), 1e-9);
  EXPECT_EQ(metadata_.all().back()->height, 2U);
  nav_msgs::GetMap call;
  ASSERT_TRUE(ros::service::waitForService("static_map", ros::Duration(kPatienceS)));
  ASSERT_TRUE(ros::service::call("static_map", call));
  EXPECT_EQ(call.response.map.data, ground_.cells);
  const Inbox<nav_msgs::OccupancyGrid> late("map");
  EXPECT_TRUE(late.wait_for_count(1)) << "latched";
}

TEST_F(MapServerTest, FloorsByName) {
  ASSERT_TRUE(
      manager_.load("/map_server", "map_server", {{"floors", path("floors.yaml")}, {"floor", "first"}}))
      << log_.text();
  ASSERT_TRUE(maps_.wait_for_count(1));
  EXPECT_EQ(maps_.all().back()->data, std::vector<std::int8_t>{100});
  const auto changed = change("ground");
  EXPECT_EQ(changed.result, LoadMap::Response::RESULT_SUCCESS);
  EXPECT_EQ(changed.map.data, ground_.cells);
  ASSERT_TRUE(maps_.wait_for_count(2));
  EXPECT_EQ(maps_.all().back()->data, ground_.cells);
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.value("map") == "ground"; }));
}

TEST_F(MapServerTest, WhatCannotBeLoadedLeavesTheMap) {
  ASSERT_TRUE(manager_.load("/map_server", "map_server", {{"floors", path("floors.yaml")}})) << log_.text();
  ASSERT_TRUE(maps_.wait_for_count(1));
  EXPECT_EQ(change("cellar").result, LoadMap::Response::RESULT_MAP_DOES_NOT_EXIST);
  EXPECT_TRUE(log_.wait("there is no floor \"cellar\""));
  EXPECT_EQ(change(path("none.yaml")).result, LoadMap::Response::RESULT_MAP_DOES_NOT_EXIST);
  EXPECT_EQ(change(path("floors.yaml")).result, LoadMap::Response::RESULT_INVALID_MAP_DATA);
  EXPECT_EQ(change("").result, LoadMap::Response::RESULT_MAP_DOES_NOT_EXIST);
  EXPECT_TRUE(never([this] { return maps_.count() > 1; }));
  EXPECT_EQ(change("file://" + path("first.yaml")).result, LoadMap::Response::RESULT_SUCCESS);
  EXPECT_TRUE(maps_.wait_for_count(2));
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.number("failures") == 4; }));
}

TEST_F(MapServerTest, BadParametersAreRefused) {
  EXPECT_FALSE(manager_.load("/map_server", "map_server", {}));
  EXPECT_TRUE(log_.wait("give map_file"));
  EXPECT_FALSE(manager_.load("/map_server", "map_server", {{"map_file", path("none.yaml")}}));
  EXPECT_TRUE(log_.wait("none.yaml"));
  EXPECT_FALSE(
      manager_.load("/map_server", "map_server", {{"map_file", path("ground.yaml")}, {"floor", "first"}}));
  EXPECT_TRUE(log_.wait("needs floors"));
  EXPECT_FALSE(
      manager_.load("/map_server", "map_server", {{"floors", path("floors.yaml")}, {"floor", "roof"}}));
  EXPECT_TRUE(log_.wait("there is no floor \"roof\""));
}

TEST_F(MapServerTest, TheProgramTakesAFileAsMapServerDoes) {
  const ChildProcess program({program_path(), path("ground.yaml"), "__name:=one_map"});
  EXPECT_TRUE(maps_.wait_for_count(1));
  ChildProcess wrong({program_path(), path("none.yaml"), "__name:=no_map"});
  EXPECT_EQ(wrong.wait_for_end(), 1);
}

}  // namespace
}  // namespace extperfc::ros_test
