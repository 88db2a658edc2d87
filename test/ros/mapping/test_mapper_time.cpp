// Time that runs back, stands still, or is simulated.
#include "test/ros/mapping/mapper_test.hpp"
#include "test/ros/support/simulated_time.hpp"

namespace extperfc::ros_test {
namespace {

class MapperTimeTest : public MapperTest {};

TEST_F(MapperTimeTest, ARecordingThatBeginsAgain) {
  mount_lidar();
  load({{"odometry", "tf"}});
  const auto begin = now_;
  ASSERT_TRUE(drive(round_trip()));
  const auto key_frames = diagnostics_.latest().number("key frames");
  now_ = begin;  // the path ended where it began, so the robot stands where the recording begins
  // The first scan comes before tf has odometry of the new time: it may be dropped.
  publish_odometry(odom_T_room_, now_ + ros::Duration(kPeriodS));
  send_scan({0, 0, 0});
  EXPECT_TRUE(log_.wait("time ran back"));
  poses_.clear();  // the stamps come again
  for (const auto& pose : straight_path({0, 0, 0}, {2, -0.5, 0.5}, 20)) {
    const auto found = feed(pose);
    ASSERT_TRUE(found) << diagnostics_.latest().message();
    EXPECT_LT(error_m(*found, pose), 0.1)
        << pose.x << " found " << found->x << " " << found->y << " " << found->yaw;
  }
  EXPECT_TRUE(diagnostics_.wait_latest([&](const Report& r) {
    return r.number("time ran back") == 1 && r.number("key frames") >= key_frames;
  })) << diagnostics_.latest().message();
  expect_map_of_the_room(map_now());
}

TEST_F(MapperTimeTest, SmallStepsBackAreDisorderOnly) {
  mount_lidar();
  load();
  ASSERT_TRUE(drive(straight_path({0, 0, 0}, {0.5, 0, 0}, 5)));
  now_ -= ros::Duration(0.25);
  ASSERT_TRUE(drive(straight_path({0.5, 0, 0}, {1, 0, 0}, 5)));
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.number("scans used") == 10; }));
  EXPECT_EQ(diagnostics_.latest().number("time ran back"), 0);
}

TEST_F(MapperTimeTest, DiagnosticsAndFramesSurviveAClockThatRunsBack) {
  const SimulatedTime time(1000.0);
  now_ = ros::Time(999.0);
  mount_lidar();
  load();
  ASSERT_TRUE(feed({0, 0, 0}));
  for (int i = 1; i <= 20; ++i) {
    SimulatedTime::set(1000.0 + 0.1 * i);
    (void)never([] { return false; }, 0.02);
  }
  ASSERT_TRUE(wait_for([this] { return last_transform("odom").has_value(); }));
  SimulatedTime::set(10.0);
  diagnostics_.forget();
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.number("scans used") == 1; }))
      << "diagnostics by the updater's own clock would stay silent for 990 s";
  double second = 10.0;
  EXPECT_TRUE(wait_for([&] {
    SimulatedTime::set(second += 0.1);
    const auto transform = last_transform("odom");
    return transform && transform->header.stamp < ros::Time(900.0);
  })) << "no stamps from before";
}

TEST_F(MapperTimeTest, NoStampTwiceWhileTimeStandsStill) {
  const SimulatedTime time(500.0);
  now_ = ros::Time(499.0);
  mount_lidar();
  load();
  ASSERT_TRUE(feed({0, 0, 0}));
  double second = 500.0;
  ASSERT_TRUE(wait_for([&] {
    SimulatedTime::set(second += 0.1);
    return last_transform("odom").has_value();
  }));
  const auto count = [this] {
    std::map<ros::Time, int> stamps;
    int max_count = 0;
    for (const auto& message : transforms_.all())
      for (const auto& transform : message->transforms)
        if (transform.header.frame_id == "map")
          max_count = std::max(max_count, ++stamps[transform.header.stamp]);
    return max_count;
  };
  EXPECT_TRUE(never([&] { return count() > 1; }, 0.3));
}

}  // namespace
}  // namespace extperfc::ros_test
