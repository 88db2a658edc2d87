// What goes wrong on a robot: the base stands, says why, and goes on when it can.
#include <cmath>

#include "test/ros/navigate/navigator_test.hpp"

namespace extperfc::ros_test {
namespace {

using State = actionlib::SimpleClientGoalState;

// The limit of the data's age, a control cycle, and what a loaded machine adds to the fake robot's clock.
constexpr double kSlackS = 0.2;

class NavigatorFaults : public NavigatorTest {
 protected:
  void drive() {
    load();
    client_.sendGoal(goal(3, 0));
    ASSERT_TRUE(wait_until_it_drives()) << log_.text();
  }
  void expect_reason(const std::string& text) {
    const auto reason = [&] {
      const auto all = status_.all();
      return all.empty() ? std::string() : all.back()->reason;
    };
    EXPECT_TRUE(wait_for([&] { return reason().find(text) != std::string::npos; })) << reason();
  }
  void expect_goal_reached() {
    ASSERT_TRUE(wait_for_end()) << log_.text();
    EXPECT_EQ(client_.getState(), State::SUCCEEDED) << text();
    EXPECT_NEAR(robot_.pose().x, 3, 0.1);
  }
};

TEST_F(NavigatorFaults, TheLidarIsSilent) {
  drive();
  robot_.silence_scan(true);
  const double stood_s = robot_.seconds_until_it_stands();
  EXPECT_GE(stood_s, 0);
  EXPECT_LE(stood_s, 0.35 + 0.2 + kSlackS) << "within 200 ms of the scan's limit";
  expect_reason("the newest scan is");
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.is_warning_about("the newest scan is"); }));
  robot_.silence_scan(false);
  expect_goal_reached();
}

TEST_F(NavigatorFaults, OdometryIsSilent) {
  drive();
  robot_.silence_odometry(true);
  const double stood_s = robot_.seconds_until_it_stands();
  EXPECT_GE(stood_s, 0);
  EXPECT_LE(stood_s, 0.2 + 0.2 + kSlackS);
  expect_reason("odometry on /odom is");
  robot_.silence_odometry(false);
  expect_goal_reached();
}

TEST_F(NavigatorFaults, OdometryJumps) {
  drive();
  robot_.jump_odometry({5, 3, 1});
  EXPECT_TRUE(log_.wait("the pose jumped in odometry"));
  expect_goal_reached();
}

TEST_F(NavigatorFaults, TheRobotIsCarriedAway) {
  drive();
  robot_.put({-3, 2, 2});
  EXPECT_TRUE(log_.wait("the pose jumped"));
  expect_goal_reached();
}

TEST_F(NavigatorFaults, TheClockRunsBack) {
  drive();
  robot_.jump_clock(-500);
  EXPECT_TRUE(log_.wait("time ran back"));
  expect_goal_reached();
}

TEST_F(NavigatorFaults, TheClockJumpsForwards) {
  drive();
  robot_.jump_clock(500);
  expect_goal_reached();
}

TEST_F(NavigatorFaults, TheMapIsReplacedWhileItDrives) {
  drive();
  auto closed = map_;
  fill(closed, {0.9, -0.8, 0}, {1.1, 0.8, 0});
  robot_.set_world(closed);
  publish_map(closed);
  ASSERT_TRUE(wait_for_end(60));
  EXPECT_EQ(client_.getState(), State::ABORTED);
  EXPECT_EQ(text().rfind("no_path: ", 0), 0U) << text();
  EXPECT_LT(robot_.pose().x, 0.7) << "in front of the wall";
}

TEST_F(NavigatorFaults, AnObstacleOnThePathIsDrivenAround) {
  load();
  auto world = map_;
  fill(world, {-0.6, -0.3, 0}, {-0.3, 0.3, 0});
  robot_.set_world(world);
  client_.sendGoal(goal(3, 0));
  expect_goal_reached();
}

TEST_F(NavigatorFaults, WithoutAMapItSaysSo) {
  ASSERT_TRUE(manager_.load("/navigator", "navigator", params()));
  ASSERT_TRUE(wait_for([&] { return client_.isServerConnected(); }));
  client_.sendGoal(goal(3, 0));
  expect_reason("no map on /map");
  publish_map(map_);
  expect_goal_reached();
}

TEST_F(NavigatorFaults, UnloadingStopsTheBase) {
  drive();
  manager_.unload("/navigator");
  EXPECT_GE(robot_.seconds_until_it_stands(), 0);
  ASSERT_TRUE(wait_for_end());
  EXPECT_EQ(client_.getState(), State::PREEMPTED);
}

}  // namespace
}  // namespace extperfc::ros_test
