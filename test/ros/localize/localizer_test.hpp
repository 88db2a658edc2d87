#pragma once

#include <optional>
#include <string>
#include <vector>

#include <geometry_msgs/PoseArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/OccupancyGrid.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>

#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

#include "test/ros/support/inbox.hpp"
#include "test/ros/support/manager.hpp"
#include "test/ros/support/watch.hpp"

namespace extperfc::ros_test {

/// A room of 8 x 6 m around the origin of `map`, without symmetry: a partition, a cupboard, a pillar.
[[nodiscard]] OccupancyGrid furnished_room();
/// A bare hall of 16 x 12 m, without any wall of the room.
[[nodiscard]] OccupancyGrid bare_hall();

/// The scanner: 180 rays all around, up to 12 m. `map_T_scanner` must lie in a free cell.
[[nodiscard]] sensor_msgs::LaserScan cast(const OccupancyGrid& map, const Pose2& map_T_scanner,
                                          const std::string& frame, const ros::Time& stamp);

[[nodiscard]] double yaw_difference_rad(const Pose2& a, const Pose2& b);

/// The nodelet, a map, and a robot with exact odometry in a separate frame and a scanner, in simulated
/// time.
class LocalizerTest : public testing::Test {
 protected:
  LocalizerTest();
  ~LocalizerTest() override;

  /// Loads /localizer with `more` in addition to a setting for this room, and connects everything, the room's
  /// map too.
  void load(const Params& more = {});
  void load_without_map(const Params& more = {});
  void unload() { manager_.unload("/localizer"); }
  [[nodiscard]] static Params params();

  void publish_map(const OccupancyGrid& map);
  void publish_mount(const std::string& frame, const Pose2& base_T_scanner, bool upside_down = false);

  /// Sets the clock to now_ and publishes odom -> base_link.
  void broadcast_odometry();
  /// 0.1 s later: tf, then the scan of where the robot is now. Does not wait.
  void tick();
  /// As tick(), and waits for the transform map -> odom that the scan leads to. No value when none comes.
  std::optional<Pose2> locate();
  /// Drives and rotates, in steps of 0.1 s; located at every step. The last pose in the map.
  std::optional<Pose2> drive(double distance_m, double rotation_rad, int steps);
  /// Around the room and back to the start.
  std::optional<Pose2> drive_around();
  void give_pose(const Pose2& pose, double sigma_m = 0.3, double sigma_rad = 0.2,
                 const std::string& frame = "map", std::optional<ros::Time> stamp = std::nullopt);
  /// Ticks until `condition` holds.
  [[nodiscard]] bool tick_until(const std::function<bool()>& condition);

  void expect_near(const Pose2& estimate, double error_m = 0.1, double error_rad = 0.05) const;

  [[nodiscard]] std::vector<geometry_msgs::TransformStamped> transforms() const;  ///< map -> odom so far

  ros::Time now_;  ///< of the simulated clock
  Pose2 map_T_base_;
  Pose2 map_T_odom_{1.0, -0.5, 0.4};
  OccupancyGrid room_{furnished_room()};
  OccupancyGrid seen_{room_};  ///< what the scanner sees
  std::string scanner_frame_{"laser"};
  Pose2 base_T_scanner_{0.2, 0, 0};

  ros::NodeHandle handle_;
  ros::Publisher scan_{handle_.advertise<sensor_msgs::LaserScan>("scan", 10)};
  ros::Publisher map_{handle_.advertise<nav_msgs::OccupancyGrid>("map", 1, true)};
  ros::Publisher initialpose_{handle_.advertise<geometry_msgs::PoseWithCovarianceStamped>("initialpose", 10)};
  tf2_ros::TransformBroadcaster broadcaster_;
  tf2_ros::StaticTransformBroadcaster static_broadcaster_;
  Inbox<tf2_msgs::TFMessage> tf_{"/tf"};
  Inbox<geometry_msgs::PoseWithCovarianceStamped> poses_{"amcl_pose"};
  DiagnosticsWatch diagnostics_{"localizer"};
  LogWatch log_;
  Manager manager_;
};

}  // namespace extperfc::ros_test
