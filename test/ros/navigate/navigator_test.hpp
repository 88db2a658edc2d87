#pragma once

#include <atomic>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <actionlib/client/simple_action_client.h>
#include <extperfc/FollowWaypointsAction.h>
#include <extperfc/NavigationStatus.h>
#include <geometry_msgs/Twist.h>
#include <gtest/gtest.h>
#include <move_base_msgs/MoveBaseAction.h>
#include <nav_msgs/GetPlan.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_ros/transform_broadcaster.h>

#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

#include "test/ros/support/inbox.hpp"
#include "test/ros/support/manager.hpp"
#include "test/ros/support/watch.hpp"

namespace extperfc::ros_test {

/// A hall of 10 x 8 m around the origin of `map`, with a wall that leaves an opening of 1.6 m.
[[nodiscard]] OccupancyGrid hall();
/// Cells whose middle lies between two corners become occupied.
void fill(OccupancyGrid& map, const Pose2& low, const Pose2& high);

/// A robot that does exactly what cmd_vel says, with odometry, tf and a scanner that sees `world`, in
/// simulated time that runs in a thread at twice real time.
class FakeRobot {
 public:
  FakeRobot();
  ~FakeRobot();
  FakeRobot(const FakeRobot&) = delete;
  FakeRobot& operator=(const FakeRobot&) = delete;

  [[nodiscard]] Pose2 pose() const;  ///< in the map
  [[nodiscard]] Pose2 odom_T_map() const;
  [[nodiscard]] Twist2 velocity() const;  ///< commanded last, zero after 0.3 s of silence
  [[nodiscard]] ros::Time now() const;
  void set_world(const OccupancyGrid& world);  ///< what the scanner sees
  /// Stands 0.72 m high, so that the scanner sees it from kTableFromM on; scans have heights then.
  void set_table(const OccupancyGrid& table);
  static constexpr float kTableFromM = 1.2F;
  void silence_scan(bool on) { scan_silent_ = on; }
  void silence_odometry(bool on) { odometry_silent_ = on; }
  void put(const Pose2& map_T_base);    ///< carried away: odometry does not know, the localizer does
  void jump_odometry(const Pose2& by);  ///< odometry restarts; the localizer keeps the pose
  void jump_clock(double seconds);
  /// Simulated time from now on until the commanded velocity is zero; negative: it was not within 5 s of
  /// real time.
  [[nodiscard]] double seconds_until_it_stands() const;

 private:
  void run();
  void step();
  void publish_scan(const Pose2& map_T_base, const ros::Time& stamp);

  ros::NodeHandle handle_;
  mutable std::mutex mutex_;  ///< guards what follows
  OccupancyGrid world_;
  std::optional<OccupancyGrid> table_;
  ros::Time now_;
  Pose2 odom_T_base_;
  Pose2 map_T_odom_;
  Twist2 command_;
  ros::Time commanded_;
  std::atomic<bool> scan_silent_{false};
  std::atomic<bool> odometry_silent_{false};
  std::atomic<bool> stopping_{false};
  int ticks_{0};
  tf2_ros::TransformBroadcaster broadcaster_;
  ros::Publisher odometry_{handle_.advertise<nav_msgs::Odometry>("odom", 10)};
  ros::Publisher scan_{handle_.advertise<sensor_msgs::LaserScan>("scan", 5)};
  ros::Subscriber subscriber_;
  std::thread thread_;
};

using MoveBaseClient = actionlib::SimpleActionClient<move_base_msgs::MoveBaseAction>;

/// The nodelet, the robot and a map.
class NavigatorTest : public testing::Test {
 protected:
  void load(const Params& more = {});
  void publish_map(const OccupancyGrid& map);
  [[nodiscard]] static Params params();
  [[nodiscard]] static move_base_msgs::MoveBaseGoal goal(double x, double y, double yaw = 0,
                                                         const std::string& frame = "map");
  [[nodiscard]] bool wait_for_end(double patience_s = 40);
  /// Text of the state that the goal ended with.
  [[nodiscard]] std::string text() { return client_.getState().getText(); }
  [[nodiscard]] bool wait_until_it_drives() const;
  [[nodiscard]] std::string last_state() const;

  LogWatch log_;
  ros::NodeHandle handle_;
  OccupancyGrid map_{hall()};
  ros::Publisher map_publisher_{handle_.advertise<nav_msgs::OccupancyGrid>("map", 1, true)};
  FakeRobot robot_;
  Manager manager_;
  MoveBaseClient client_{"move_base", false};
  Inbox<NavigationStatus> status_{"navigation_status"};
  Inbox<geometry_msgs::Twist> commands_{"cmd_vel"};
  DiagnosticsWatch diagnostics_{"navigator"};
};

}  // namespace extperfc::ros_test
