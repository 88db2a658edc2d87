// Input that is missing, late, broken or wrong: nothing crashes, the map is not destroyed, diagnostics say
// it.
#include <cmath>
#include <limits>

#include <std_srvs/Trigger.h>

#include "test/ros/mapping/mapper_test.hpp"

namespace extperfc::ros_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

/// With odometry from tf alone, and little patience.
const Params kTfOnly{{"odometry", "tf"}, {"transform_timeout_s", 0.05}};

class MapperFaultsTest : public MapperTest {
 protected:
  void expect_error(const std::string& text) {
    EXPECT_TRUE(diagnostics_.wait_latest([&](const Report& r) { return r.is_error_about(text); }))
        << text << "\n"
        << diagnostics_.latest().message();
  }
  void expect_warning(const std::string& text) {
    EXPECT_TRUE(diagnostics_.wait_latest([&](const Report& r) {
      return r.level() == 1 && r.message().find(text) != std::string::npos;
    })) << text
        << "\n"
        << diagnostics_.latest().message();
  }

  /// A scan whose ranges `spoil` changes, with odometry; its pose when it is used.
  template <typename Spoil>
  std::optional<Pose2> feed_spoilt(const Pose2& room_T_base, Spoil&& spoil) {
    const auto stamp = tick();
    publish_odometry(compose(odom_T_room_, room_T_base), stamp);
    auto message = scan_message(compose(room_T_base, base_T_laser_), stamp, {}, seed_++);
    spoil(*message);
    scans_.publish(message);
    return answer_at(stamp);
  }

  template <typename Spoil>
  void send_refused(Spoil&& spoil, const std::string& reason) {
    const auto stamp = tick();
    publish_odometry(odom_T_room_, stamp);
    auto message = scan_message(base_T_laser_, stamp);
    spoil(*message);
    scans_.publish(message);
    expect_error(reason);
  }
};

TEST_F(MapperFaultsTest, TheMissingOdometryIsNamed) {
  mount_lidar();
  load(kTfOnly);
  send_scan({0, 0, 0});
  expect_error("no transform from base_link to odom at the scan's stamp");
  expect_error("tf does not know the frame odom");
  EXPECT_TRUE(log_.wait("no transform from base_link to odom"));
  EXPECT_EQ(poses_.count(), 0U);
  ASSERT_TRUE(feed({0, 0, 0})) << "it continues when odometry comes";
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) {
    return r.level() == 0 && r.number("scans dropped: no transform") == 1;
  })) << diagnostics_.latest().message();
}

TEST_F(MapperFaultsTest, OneOutageIsLoggedOnce) {
  mount_lidar();
  load({{"odometry", "tf"}, {"transform_timeout_s", 0.0}, {"queue_size", 100}});
  for (int i = 0; i < 20; ++i) send_scan({0, 0, 0});
  EXPECT_TRUE(diagnostics_.wait_latest(
      [](const Report& r) { return r.number("scans dropped: no transform") == 20; }));
  EXPECT_EQ(log_.count("no transform from"), 1U) << log_.text();
}

TEST_F(MapperFaultsTest, TheMissingMountOfTheScannerIsNamed) {
  load(kTfOnly);
  publish_odometry(odom_T_room_, now_ + ros::Duration(kPeriodS));
  send_scan({0, 0, 0});
  expect_error("no transform from laser to base_link at the scan's stamp");
  expect_error("tf does not know the frame laser");
}

TEST_F(MapperFaultsTest, OdometryThatStoppedIsNamedWithItsAge) {
  mount_lidar();
  load(kTfOnly);
  ASSERT_TRUE(feed({0, 0, 0}));
  tick();
  send_scan({0, 0, 0});
  expect_error("the newest is 0.200 s older");
}

TEST_F(MapperFaultsTest, LateOdometryIsWaitedFor) {
  mount_lidar();
  load({{"odometry", "tf"}, {"transform_timeout_s", 20.0}});
  ASSERT_TRUE(feed({0, 0, 0}));
  const auto stamp = send_scan({0.1, 0, 0});
  EXPECT_TRUE(never([&] { return poses_.count() > 1; }, 0.3));
  publish_odometry(compose(odom_T_room_, {0.1, 0, 0}), stamp);
  EXPECT_TRUE(answer_at(stamp));
}

TEST_F(MapperFaultsTest, WithoutOdometryScansAreMatchedAlone) {
  mount_lidar();
  load({{"odometry", "auto"}, {"transform_timeout_s", 0.01}});
  first_in_room_ = Pose2{};
  for (const auto& pose : straight_path({0, 0, 0}, {1.5, -0.5, 0.5}, 40)) {
    const auto found = answer_at(send_scan(pose));
    ASSERT_TRUE(found);
    if (!first_in_map_) {
      first_in_map_ = found;
      first_in_room_ = pose;
    }
    EXPECT_LT(error_m(*found, pose), 0.08);
  }
  expect_warning("no odometry, scan matching alone: no transform from base_link to odom");
  EXPECT_TRUE(wait_for([this] { return last_transform("base_link").has_value(); }))
      << "the map joins the robot directly";
  EXPECT_FALSE(last_transform("odom"));
}

TEST_F(MapperFaultsTest, NoOdometryWanted) {
  mount_lidar();
  load({{"odometry", "none"}});
  ASSERT_TRUE(answer_at(send_scan({0, 0, 0})));
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) {
    return r.level() == 0 && r.number("scans used") == 1;
  })) << "nothing is missing: "
      << diagnostics_.latest().message();
}

TEST_F(MapperFaultsTest, OdometryThatAppearsIsUsed) {
  mount_lidar();
  load({{"transform_timeout_s", 0.01}});
  ASSERT_TRUE(answer_at(send_scan({0, 0, 0})));
  ASSERT_TRUE(drive(straight_path({0, 0, 0}, {0.5, 0, 0}, 5)));
  EXPECT_TRUE(wait_for([this] { return last_transform("odom").has_value(); }));
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.level() == 0; }));
}

TEST_F(MapperFaultsTest, OdometryThatBeginsAnewDoesNotMoveTheRobot) {
  mount_lidar();
  load();
  ASSERT_TRUE(drive(straight_path({0, 0, 0}, {1, 0, 0}, 10)));
  odom_T_room_ = {-20, 30, -2};
  const auto found = feed({1.05, 0, 0});
  ASSERT_TRUE(found);
  EXPECT_LT(error_m(*found, {1.05, 0, 0}), 0.1);
  expect_warning("odometry jumped");
  EXPECT_EQ(diagnostics_.latest().number("odometry jumps"), 1);
  for (const auto& leg : {straight_path({1.05, 0, 0}, {2, 0.5, 1}, 10),
                          straight_path({2, 0.5, 1}, {0, 0, 0}, 20), round_trip()})
    for (const auto& pose : leg) {
      const auto next = feed(pose);
      ASSERT_TRUE(next);
      EXPECT_LT(error_m(*next, pose), 0.1);
    }
  expect_map_of_the_room(map_now());
}

TEST_F(MapperFaultsTest, RangesWithoutMeasurement) {
  mount_lidar();
  load();
  ASSERT_TRUE(drive(straight_path({0, 0, 0}, {1, 0, 0}, 10)));
  for (const float value : {kNan, kInf, -kInf, 0.0F, -1.0F, 1e30F})
    EXPECT_TRUE(feed_spoilt({1, 0, 0}, [&](auto& scan) { scan.ranges.assign(scan.ranges.size(), value); }))
        << value;
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.is_warning_about("too few returns"); }));
  for (const auto& pose : straight_path({1, 0, 0}, {2, 0, 0}, 10)) {
    const auto found = feed_spoilt(pose, [&](auto& scan) {
      for (std::size_t i = 0; i < scan.ranges.size(); i += 5) scan.ranges[i] = i % 2 == 0 ? kNan : 0.0F;
    });
    ASSERT_TRUE(found);
    EXPECT_LT(error_m(*found, pose), 0.06);
  }
  ASSERT_TRUE(drive(straight_path({2, 0, 0}, {0, 0, 0}, 20)) && drive(round_trip()));
  expect_map_of_the_room(map_now());
}

TEST_F(MapperFaultsTest, ScansOfOtherSizes) {
  mount_lidar();
  load();
  ASSERT_TRUE(feed({0, 0, 0}));
  const Lidar lidars[] = {{181, -M_PI / 2, M_PI / 180, 20.0, 0.01},
                          {1440, -M_PI, M_PI / 720, 20.0, 0.01},
                          {270, 3 * M_PI / 4, -M_PI / 180, 20.0, 0.01},
                          {3000, -M_PI, 2 * M_PI / 3000, 20.0, 0.01}};
  int i = 0;
  for (const auto& pose : straight_path({0, 0, 0}, {2, 0.5, 1}, 20)) {
    const auto stamp = tick();
    publish_odometry(compose(odom_T_room_, pose), stamp);
    scans_.publish(scan_message(compose(pose, base_T_laser_), stamp, lidars[i++ % 4], seed_++));
    const auto found = answer_at(stamp);
    ASSERT_TRUE(found) << diagnostics_.latest().message();
    EXPECT_LT(error_m(*found, pose), 0.06) << i;
  }
}

TEST_F(MapperFaultsTest, NonsenseIsRefusedAndNamed) {
  mount_lidar();
  load();
  send_refused([](auto& scan) { scan.angle_increment = 0; }, "angle_increment is 0");
  send_refused([](auto& scan) { scan.ranges.clear(); }, "it has no rays");
  send_refused([](auto& scan) { scan.angle_min = kNan; }, "not a finite number");
  send_refused([](auto& scan) { scan.range_max = -1; }, "range_max");
  send_refused([](auto& scan) { scan.angle_increment = 1; }, "angle_increment in radians");
  send_refused([](auto& scan) { scan.header.stamp = ros::Time(); }, "no stamp or no frame_id");
  send_refused([](auto& scan) { scan.header.frame_id = ""; }, "no stamp or no frame_id");
  ASSERT_TRUE(feed({0, 0, 0}));
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.number("scans refused") == 7; }));
}

TEST_F(MapperFaultsTest, ATiltedScannerIsRefused) {
  mount_lidar(0.0, 0.3);
  load();
  publish_odometry(odom_T_room_, now_ + ros::Duration(kPeriodS));
  send_scan({0, 0, 0});
  expect_error("laser is tilted by 17.2 degrees");
}

TEST_F(MapperFaultsTest, ALidarThatStops) {
  mount_lidar();
  load({{"timeout_s", 0.3}});
  ASSERT_TRUE(feed({0, 0, 0}));
  expect_warning("no message on /scan");
  ASSERT_TRUE(feed({0, 0, 0}));
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.level() == 0; }));
}

TEST_F(MapperFaultsTest, TheOldestScansAreDropped) {
  mount_lidar();
  load({{"odometry", "tf"}, {"transform_timeout_s", 20.0}, {"queue_size", 3}});
  const auto first = send_scan({0, 0, 0});  // the worker waits for its odometry
  ASSERT_TRUE(diagnostics_.wait_latest(
      [](const Report& r) { return r.number("scan received") == 1 && r.number("waiting") == 0; }));
  std::vector<ros::Time> stamps;
  for (int i = 0; i < 10; ++i) {
    stamps.push_back(send_scan({0, 0, 0}));
    // One after the other: the subscription's own queue must not be what drops them.
    ASSERT_TRUE(
        diagnostics_.wait_latest([&](const Report& r) { return r.number("scan received") == i + 2; }));
  }
  expect_warning("scans come faster than they are used");
  EXPECT_EQ(diagnostics_.latest().number("scans dropped: queue full"), 7);
  publish_odometry(odom_T_room_, first);
  for (const auto& stamp : stamps) publish_odometry(odom_T_room_, stamp);
  EXPECT_TRUE(answer_at(stamps.back())) << "the newest are kept";
  EXPECT_TRUE(answer_at(first));
  EXPECT_EQ(poses_.count(), 4U);
}

TEST_F(MapperFaultsTest, UnloadsWhileItWaits) {
  mount_lidar();
  load({{"odometry", "tf"}, {"transform_timeout_s", 60.0}});
  for (int i = 0; i < 20; ++i) send_scan({0, 0, 0});
  const auto before = ros::WallTime::now();
  manager_.unload("/mapper");
  EXPECT_LT((ros::WallTime::now() - before).toSec(), 10.0) << "it must not wait for the transform";
}

}  // namespace
}  // namespace extperfc::ros_test
