// Where maps and poses come from and go to, and the program that stands in amcl's place.
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <nav_msgs/GetMap.h>
#include <nav_msgs/SetMap.h>
#include <ros/param.h>
#include <std_srvs/Empty.h>

#include "extperfc/sources/mrpt_map.hpp"
#include "extperfc/world/map_file.hpp"

#include "ros/convert/occupancy_grid.hpp"
#include "ros/convert/planar_pose.hpp"
#include "test/ros/localize/localizer_test.hpp"
#include "test/ros/support/child_process.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::ros_test {
namespace {

TEST_F(LocalizerTest, TheMapComesFromAFile) {
  const TemporaryFolder folder;
  ASSERT_TRUE(save_map(room_, folder.path() / "room"));
  load_without_map({{"map_file", (folder.path() / "room.yaml").string()}, {"use_map_topic", false}});
  const auto pose = drive_around();
  ASSERT_TRUE(pose) << diagnostics_.latest().message();
  expect_near(*pose);
}

TEST_F(LocalizerTest, TheMapComesFromAFileOfMrpts) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "room.gridmap.gz";
  const auto saved = sources::save_gridmap(room_, file);
  if (!saved && saved.error().code == ErrorCode::kUnsupported) GTEST_SKIP() << saved.error().message;
  ASSERT_TRUE(saved) << saved.error().message;
  load_without_map({{"map_file", file.string()}, {"use_map_topic", false}});
  const auto pose = drive_around();
  ASSERT_TRUE(pose) << diagnostics_.latest().message();
  expect_near(*pose);
}

TEST_F(LocalizerTest, AMissingMapFileIsRefused) {
  EXPECT_FALSE(manager_.load("/localizer", "localizer", {{"map_file", "/no/such/map.yaml"}}));
  EXPECT_TRUE(log_.wait("/no/such/map.yaml"));
}

TEST_F(LocalizerTest, TheMapComesFromTheServiceAsSoonAsItIsThere) {
  load_without_map({{"use_map_topic", false}});
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) {
    return r.is_warning_about("no map yet: waiting for the service " + ros::names::resolve("static_map"));
  }));
  using Answer = boost::function<bool(nav_msgs::GetMap::Request&, nav_msgs::GetMap::Response&)>;
  std::atomic<int> calls{0};
  const Answer answer = [&](nav_msgs::GetMap::Request&, nav_msgs::GetMap::Response& response) {
    ++calls;
    std_msgs::Header header;
    header.frame_id = "map";
    response.map = ros_convert::to_message(room_, header);
    return calls > 1;  // the first call fails
  };
  const auto service =
      handle_.advertiseService<nav_msgs::GetMap::Request, nav_msgs::GetMap::Response>("static_map", answer);
  ASSERT_TRUE(tick_until([&] { return !transforms().empty(); })) << diagnostics_.latest().message();
  EXPECT_EQ(calls, 2) << "asked again after a failure, and not after an answer";
}

TEST_F(LocalizerTest, UnloadsWhileTheMapServiceHangs) {
  load_without_map({{"use_map_topic", false}});
  std::atomic<bool> called{false};
  std::atomic<bool> released{false};
  using Answer = boost::function<bool(nav_msgs::GetMap::Request&, nav_msgs::GetMap::Response&)>;
  const Answer hang = [&](nav_msgs::GetMap::Request&, nav_msgs::GetMap::Response&) {
    called = true;
    return wait_for([&] { return released.load(); }, 60);
  };
  auto service =
      handle_.advertiseService<nav_msgs::GetMap::Request, nav_msgs::GetMap::Response>("static_map", hang);
  ASSERT_TRUE(wait_for([&] { return called.load(); }));
  unload();
  EXPECT_FALSE(released) << "unloaded before the service answered";
  released = true;
}

TEST_F(LocalizerTest, SetMapGivesMapAndPose) {
  load();
  ASSERT_TRUE(locate());
  nav_msgs::SetMap service;
  std_msgs::Header header;
  header.frame_id = "map";
  service.request.map = ros_convert::to_message(bare_hall(), header);
  service.request.initial_pose.header.frame_id = "map";
  service.request.initial_pose.pose.pose = ros_convert::to_pose_message({6, 4, 1.0});
  service.request.initial_pose.pose.covariance =
      ros_convert::to_covariance_message(Eigen::Vector3d(0.01, 0.01, 0.01).asDiagonal());
  ASSERT_TRUE(ros::service::call("set_map", service));
  EXPECT_TRUE(service.response.success);
  seen_ = bare_hall();
  map_T_odom_ = compose({6, 4, 1.0}, inverse(compose(inverse(map_T_odom_), map_T_base_)));
  map_T_base_ = {6, 4, 1.0};
  const auto pose = drive(0.5, 2.0, 5);
  ASSERT_TRUE(pose);
  expect_near(*pose);
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.value("lost") == "no"; }));
}

TEST_F(LocalizerTest, SetMapRefusesWhatCannotBe) {
  load();
  nav_msgs::SetMap service;
  service.request.initial_pose.pose.pose.orientation.w = 1;
  ASSERT_TRUE(ros::service::call("set_map", service));
  EXPECT_FALSE(service.response.success);
  EXPECT_TRUE(log_.wait("set_map: the map has no cells"));
  service.request.map = ros_convert::to_message(room_, {});
  service.request.initial_pose.pose.pose.orientation.w = 0;
  ASSERT_TRUE(ros::service::call("set_map", service));
  EXPECT_FALSE(service.response.success);
  const auto pose = drive(0.5, 0.3, 5);
  ASSERT_TRUE(pose) << "it continues with its map";
  expect_near(*pose);
}

TEST_F(LocalizerTest, ANewMapOfTheTopicCountsUnlessTheFirstShallStay) {
  for (const bool first_only : {true, false}) {
    seen_ = room_;
    load({{"first_map_only", first_only}});
    ASSERT_TRUE(drive(0.3, 0.3, 3));
    publish_map(bare_hall());
    seen_ = bare_hall();
    ASSERT_TRUE(drive(0.3, 1.5, 6));
    const std::string lost = first_only ? "yes" : "no";
    EXPECT_TRUE(diagnostics_.wait_latest([&](const Report& r) { return r.value("lost") == lost; }))
        << first_only;
    unload();
    diagnostics_.forget();
    poses_.clear();
    tf_.clear();
    map_T_base_ = {};
  }
}

TEST_F(LocalizerTest, ThePoseIsStoredAndTheNextStartBeginsThere) {
  map_T_base_ = {-2, -1, 0.8};
  const Params start{
      {"initial_pose_x", -2.0}, {"initial_pose_y", -1.0}, {"initial_pose_a", 0.8}, {"save_pose_rate", 10.0}};
  load(start);
  ASSERT_TRUE(drive(0.8, 0.4, 4));
  const auto stored = [](const char* key) {
    double value = 1e9;
    (void)ros::param::get(std::string("/localizer/") + key, value);
    return value;
  };
  // The values are stored one after the other, and for a pose on the way first.
  EXPECT_TRUE(wait_for([&] {
    return distance_m({stored("initial_pose_x"), stored("initial_pose_y"), 0}, map_T_base_) < 0.15 &&
           std::abs(stored("initial_pose_a") - map_T_base_.yaw) < 0.1 && stored("initial_cov_xx") < 0.04 &&
           stored("initial_cov_aa") < 0.02;
  })) << stored("initial_cov_xx")
      << " m^2, " << stored("initial_cov_aa") << " rad^2";
  Params again = start;
  for (const char* key : {"initial_pose_x", "initial_pose_y", "initial_pose_a", "initial_cov_xx",
                          "initial_cov_yy", "initial_cov_aa"})
    again[key] = stored(key);
  unload();
  load(again);
  const auto pose = locate();
  ASSERT_TRUE(pose);
  expect_near(*pose, 0.2, 0.1);
}

TEST_F(LocalizerTest, WithoutARateThePoseIsNotStored) {
  load();
  ASSERT_TRUE(drive(0.8, 0.4, 4));
  EXPECT_TRUE(never([] { return ros::param::has("/localizer/initial_pose_x"); }, 0.5));
}

/// The program lies beside this one.
std::string program_path() {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "localizer").string();
}

/// The program in amcl's place: name, parameters and remapping of a launch file for amcl.
TEST_F(LocalizerTest, TheProgramStandsInForAmcl) {
  publish_map(room_);
  publish_mount(scanner_frame_, base_T_scanner_);
  (void)ros::param::del("/amcl");
  for (const auto& [key, value] : params()) ros::param::set("/amcl/" + key, value);
  ros::param::set("/amcl/save_pose_rate", 0.001);
  ros::param::set("/amcl/odom_model_type", "omni");
  Inbox<geometry_msgs::PoseArray> clouds("particlecloud");
  ros::Publisher base_scan = handle_.advertise<sensor_msgs::LaserScan>("base_scan", 10);
  std::optional<ChildProcess> program;
  program.emplace(std::vector<std::string>{program_path(), "scan:=base_scan", "__name:=amcl"});
  ASSERT_TRUE(wait_for([&] { return base_scan.getNumSubscribers() > 0; })) << log_.text();
  EXPECT_TRUE(wait_for([&] {
    tick();
    base_scan.publish(cast(seen_, compose(map_T_base_, base_T_scanner_), scanner_frame_, now_));
    return wait_for([&] { return poses_.count() > 0 && clouds.count() > 0 && !transforms().empty(); }, 0.05);
  }));
  for (const char* service : {"/global_localization", "/request_nomotion_update", "/set_map"})
    EXPECT_TRUE(ros::service::exists(service, false)) << service;
  program.reset();  // interrupted
  EXPECT_TRUE(ros::param::has("/amcl/initial_pose_x")) << "the last pose is stored at the end";
  (void)ros::param::del("/amcl");
}

TEST_F(LocalizerTest, TheProgramRefusesBadParameters) {
  ros::param::set("/bad/min_particels", 100);
  const TemporaryFolder folder;
  const auto log = folder.path() / "log";
  ChildProcess program({"sh", "-c", program_path() + " __name:=bad >" + log.string() + " 2>&1"});
  EXPECT_EQ(program.wait_for_end(), 1);
  std::ifstream file(log);
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  EXPECT_NE(text.find("/bad/min_particels is not a parameter"), std::string::npos) << text;
  (void)ros::param::del("/bad");
}

}  // namespace
}  // namespace extperfc::ros_test
