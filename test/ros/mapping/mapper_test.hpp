#pragma once

#include <optional>
#include <string>
#include <vector>

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/OccupancyGrid.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>

#include "extperfc/world/pose.hpp"

#include "test/ros/mapping/room.hpp"
#include "test/ros/support/inbox.hpp"
#include "test/ros/support/manager.hpp"
#include "test/ros/support/watch.hpp"

namespace extperfc::ros_test {

/// The straight path from one pose to another in equal steps, without the first and with the last.
[[nodiscard]] std::vector<Pose2> straight_path(const Pose2& from, const Pose2& to, int steps);

/// A robot in the room of room.hpp: the test publishes its scans, and where odometry believes it to be.
class MapperTest : public testing::Test {
 protected:
  static constexpr double kPeriodS = 0.1;  ///< from scan to scan, in stamps

  void load(const Params& more = {});
  /// The lidar sits on the robot from now on; `roll` pi hangs it upside down.
  void mount_lidar(double roll_rad = 0.0, double pitch_rad = 0.0);
  void publish_odometry(const Pose2& odom_T_base, const ros::Time& stamp);

  /// The next stamp, kPeriodS later than the last.
  ros::Time tick() { return now_ += ros::Duration(kPeriodS); }

  /// One scan from here with its odometry (the truth behind `odom_T_room_`); returns its pose in the map, or
  /// nothing when none comes.
  std::optional<Pose2> feed(const Pose2& room_T_base);
  /// feed() at every pose; false when one got no answer.
  [[nodiscard]] bool drive(const std::vector<Pose2>& poses);
  /// Sends a scan without odometry and without waiting.
  ros::Time send_scan(const Pose2& room_T_base);
  [[nodiscard]] std::optional<Pose2> answer_at(const ros::Time& stamp) const;

  /// A drive of 12 m through the whole room and back.
  [[nodiscard]] static std::vector<Pose2> round_trip();
  /// How far `map_T_base` is from where the robot is, measured from where it was at the first scan [m].
  [[nodiscard]] double error_m(const Pose2& map_T_base, const Pose2& room_T_base) const;
  /// The newest map; null when none comes.
  [[nodiscard]] nav_msgs::OccupancyGridConstPtr map() const;
  /// What dynamic_map answers; empty when there is none.
  [[nodiscard]] static nav_msgs::OccupancyGrid map_now();
  /// Fraction of the occupied cells within `tolerance_m` of a wall, and fraction of the visited poses that
  /// are free.
  void expect_map_of_the_room(const nav_msgs::OccupancyGrid& map, double tolerance_m = 0.12) const;
  [[nodiscard]] std::optional<geometry_msgs::TransformStamped> last_transform(const std::string& child) const;

  ros::NodeHandle handle_;
  tf2_ros::TransformBroadcaster broadcaster_;
  tf2_ros::StaticTransformBroadcaster static_broadcaster_;
  ros::Publisher scans_{handle_.advertise<sensor_msgs::LaserScan>("scan", 100)};
  Inbox<geometry_msgs::PoseWithCovarianceStamped> poses_{"pose"};
  Inbox<nav_msgs::OccupancyGrid> maps_{"map"};
  Inbox<tf2_msgs::TFMessage> transforms_{"/tf"};
  DiagnosticsWatch diagnostics_{"mapper"};
  LogWatch log_;
  ros::Time now_{ros::Time::now() - ros::Duration(1000.0)};
  Pose2 odom_T_room_{3, -2, 1};  ///< odometry began somewhere else
  Pose2 base_T_laser_{0.2, 0, 0.5};
  double lidar_roll_rad_{0};
  std::optional<Pose2> first_in_map_;
  std::optional<Pose2> first_in_room_;
  unsigned seed_{1};
  Manager manager_;
};

}  // namespace extperfc::ros_test
