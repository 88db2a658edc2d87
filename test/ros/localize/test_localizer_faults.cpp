// Input that is missing, late, damaged, or of another time.
#include <cmath>
#include <limits>

#include "ros/convert/planar_pose.hpp"
#include "test/ros/localize/localizer_test.hpp"

namespace extperfc::ros_test {
namespace {

TEST_F(LocalizerTest, WithoutAMapItSaysSoAndWaits) {
  load_without_map();
  EXPECT_TRUE(diagnostics_.wait([&](const Report& r) {
    return r.is_warning_about("no map yet: waiting for the topic " + ros::names::resolve("map")) &&
           r.value("map") == "none";
  }));
  for (int i = 0; i < 5; ++i) tick();
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.number("scan received") == 5; }));
  EXPECT_TRUE(transforms().empty());
  publish_map(room_);
  EXPECT_TRUE(tick_until([&] { return !transforms().empty(); }));
}

TEST_F(LocalizerTest, AMapThatIsNoneIsNamedAndTheNextOneCounts) {
  load_without_map();
  nav_msgs::OccupancyGrid bad;
  bad.info.resolution = 0.05F;
  bad.info.width = bad.info.height = 10;
  map_.publish(bad);
  EXPECT_TRUE(diagnostics_.wait(
      [](const Report& r) { return r.is_warning_about("says 10 x 10 cells, but brings 0"); }));
  auto full = room_;
  for (auto& cell : full.cells) cell = OccupancyGrid::kOccupied;
  publish_map(full);
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.is_error_about("free"); })) << "no free cell";
  publish_map(room_);
  EXPECT_TRUE(tick_until([&] { return !transforms().empty(); }));
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.level() == 0; }));
}

TEST_F(LocalizerTest, BeforeTheFirstScanItSaysWhatItWaitsFor) {
  load();
  EXPECT_TRUE(diagnostics_.wait(
      [](const Report& r) { return r.is_warning_about("waiting for the first usable scan"); }));
}

TEST_F(LocalizerTest, AMissingTransformIsNamed) {
  load({{"tf_timeout_s", 0.0}});
  now_ += ros::Duration(0.1);
  scan_.publish(cast(room_, map_T_base_, scanner_frame_, now_));
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) {
    return r.is_error_about("no transform from base_link to odom at the scan's stamp");
  }));
  scanner_frame_ = "nowhere";
  EXPECT_TRUE(tick_until(
      [&] { return diagnostics_.latest().is_error_about("no transform from nowhere to base_link"); }));
  scanner_frame_ = "laser";
  EXPECT_TRUE(tick_until([&] { return !transforms().empty(); }));
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.level() < 2; }));
}

TEST_F(LocalizerTest, ALateTransformIsWaitedFor) {
  load();
  ASSERT_TRUE(locate());
  const auto before = transforms().size();
  now_ += ros::Duration(0.1);
  scan_.publish(cast(room_, compose(map_T_base_, base_T_scanner_), scanner_frame_, now_));
  ASSERT_TRUE(diagnostics_.wait([](const Report& r) { return r.number("scan received") == 2; }));
  EXPECT_EQ(transforms().size(), before);
  broadcast_odometry();
  EXPECT_TRUE(wait_for([&] { return transforms().size() == before + 1; }));
}

TEST_F(LocalizerTest, ATiltedScannerAndAScanWithoutAStampAreNamed) {
  load();
  auto scan = cast(room_, map_T_base_, scanner_frame_, ros::Time());
  scan_.publish(scan);
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.is_error_about("the scan has no stamp"); }));
  geometry_msgs::TransformStamped mount;
  mount.header.frame_id = "base_link";
  mount.header.stamp = now_;
  mount.child_frame_id = "tilted";
  mount.transform.rotation.y = std::sin(0.3);
  mount.transform.rotation.w = std::cos(0.3);
  static_broadcaster_.sendTransform(mount);
  scanner_frame_ = "tilted";
  EXPECT_TRUE(tick_until([&] { return diagnostics_.latest().is_error_about("is tilted by 34.4 degrees"); }));
}

TEST_F(LocalizerTest, DamagedScansAreRefusedAndItGoesOn) {
  load();
  ASSERT_TRUE(locate());
  now_ += ros::Duration(0.1);
  broadcast_odometry();
  auto scan = cast(room_, compose(map_T_base_, base_T_scanner_), scanner_frame_, now_);
  scan.angle_increment = std::numeric_limits<float>::quiet_NaN();
  scan_.publish(scan);
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.level() == 2; }));
  const auto pose = drive(0.8, 0.5, 5);
  ASSERT_TRUE(pose);
  expect_near(*pose);
}

TEST_F(LocalizerTest, RaysWithoutAMeasurementDoNotMatter) {
  load();
  ASSERT_TRUE(drive(0.4, 0, 2));
  const auto nan = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < 12; ++i) {
    map_T_base_ = compose(map_T_base_, {0.1, 0, 0.3});
    now_ += ros::Duration(0.1);
    broadcast_odometry();
    auto scan = cast(room_, compose(map_T_base_, base_T_scanner_), scanner_frame_, now_);
    for (std::size_t ray = 0; ray < scan.ranges.size(); ++ray) {
      if (i == 5) scan.ranges[ray] = nan;  // nothing at all
      if (ray % 4 == 0) scan.ranges[ray] = nan;
      if (ray % 4 == 1) scan.ranges[ray] = ray % 8 == 1 ? 0.0F : -std::numeric_limits<float>::infinity();
    }
    const auto before = transforms().size();
    scan_.publish(scan);
    ASSERT_TRUE(wait_for([&] { return transforms().size() > before; })) << diagnostics_.latest().message();
  }
  const auto pose = locate();
  ASSERT_TRUE(pose);
  expect_near(*pose);
}

TEST_F(LocalizerTest, WhenTimeRunsBackThePoseIsKeptAndDiagnosticsGoOn) {
  load();
  const auto start = now_;
  const auto pose_at_start = map_T_base_;
  ASSERT_TRUE(drive(1.0, 0.6, 10));
  now_ += ros::Duration(30.0);
  ASSERT_TRUE(drive(0.3, 0.6, 3));
  // The recording starts again: clock, odometry and scans as at its start.
  now_ = start;
  map_T_base_ = pose_at_start;
  diagnostics_.forget();
  const auto before = transforms().size();
  ASSERT_TRUE(tick_until([&] { return transforms().size() > before; })) << diagnostics_.latest().message();
  EXPECT_LT(transforms().back().header.stamp.toSec(), start.toSec() + 20);
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) {
    return r.number("time ran back") >= 1 && r.level() < 2;
  })) << diagnostics_.latest().message();
  for (int i = 0; i < 3; ++i) {  // diagnostics are alive though ros time is far behind where it was
    diagnostics_.forget();
    EXPECT_TRUE(diagnostics_.wait([](const Report&) { return true; }));
  }
  const auto pose = drive(1.0, 0.6, 10);
  ASSERT_TRUE(pose);
  expect_near(*pose);
}

TEST_F(LocalizerTest, WhenOdometryStartsAnewThePoseIsKept) {
  load();
  ASSERT_TRUE(drive(0.8, 0, 4));
  map_T_odom_ = {-7, 3, -1.5};  // odometry jumps by metres
  const auto jumped = locate();
  ASSERT_TRUE(jumped);
  expect_near(*jumped, 0.3, 0.2);
  EXPECT_TRUE(log_.wait("odometry jumped"));
  const auto pose = drive_around();
  ASSERT_TRUE(pose);
  expect_near(*pose);
}

TEST_F(LocalizerTest, ASilentLidarIsAWarning) {
  load({{"timeout_s", 0.3}});
  EXPECT_TRUE(diagnostics_.wait(
      [](const Report& r) { return r.is_warning_about("no message on " + ros::names::resolve("scan")); }));
  ASSERT_TRUE(locate());
  EXPECT_TRUE(tick_until([&] { return diagnostics_.latest().level() == 0; }));
  EXPECT_TRUE(diagnostics_.wait_latest(
      [](const Report& r) { return r.is_warning_about("no message on " + ros::names::resolve("scan")); }));
}

TEST_F(LocalizerTest, ItSaysThatItIsLost) {
  load();
  ASSERT_TRUE(drive(0.4, 0, 2));
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) {
    return r.value("lost") == "no" && r.level() == 0;
  })) << diagnostics_.latest().message();
  seen_ = bare_hall();
  ASSERT_TRUE(drive(0.4, 0.6, 4));
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) {
    return r.value("lost") == "yes" && r.is_warning_about("lost: ") && std::stod(r.value("fit")) < 0.4;
  })) << diagnostics_.latest().message();
}

TEST_F(LocalizerTest, TheNewestScanReplacesAWaitingOne) {
  load();
  ASSERT_TRUE(locate());
  for (int i = 1; i <= 20; ++i) {  // no transforms for these yet: they wait
    now_ += ros::Duration(0.01);
    scan_.publish(cast(room_, compose(map_T_base_, base_T_scanner_), scanner_frame_, now_));
  }
  ASSERT_TRUE(diagnostics_.wait([](const Report& r) { return r.number("scan received") == 21; }));
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.number("dropped") == 18; }))
      << "one waits for its transform, one waits for the worker";
  broadcast_odometry();
  EXPECT_TRUE(wait_for([&] { return transforms().back().header.stamp == now_ + ros::Duration(0.25); }));
}

TEST_F(LocalizerTest, UnloadsWhileItWaitsForATransform) {
  load();
  now_ += ros::Duration(0.1);
  scan_.publish(cast(room_, map_T_base_, scanner_frame_, now_));
  ASSERT_TRUE(diagnostics_.wait([](const Report& r) { return r.number("scan received") == 1; }));
  const auto before = ros::WallTime::now();
  unload();
  EXPECT_LT((ros::WallTime::now() - before).toSec(), 4.0);
}

}  // namespace
}  // namespace extperfc::ros_test
