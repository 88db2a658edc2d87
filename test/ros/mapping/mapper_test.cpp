#include "test/ros/mapping/mapper_test.hpp"

#include <algorithm>
#include <cmath>

#include <nav_msgs/GetMap.h>
#include <ros/service.h>

#include "ros/convert/geometry.hpp"
#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_test {

std::vector<Pose2> straight_path(const Pose2& from, const Pose2& to, int steps) {
  std::vector<Pose2> poses;
  for (int i = 1; i <= steps; ++i) {
    const double ratio = static_cast<double>(i) / steps;
    poses.push_back({from.x + ratio * (to.x - from.x), from.y + ratio * (to.y - from.y),
                     wrap_angle(from.yaw + ratio * wrap_angle(to.yaw - from.yaw))});
  }
  return poses;
}

std::vector<Pose2> MapperTest::round_trip() {
  const std::vector<Pose2> corners{{0, 0, 0},    {3, -1.5, 0.8},  {3.5, 2, 2.2},
                                   {0, 1, -2.8}, {-3, 0.5, -1.5}, {0, 0, 0}};
  std::vector<Pose2> poses{corners.front()};
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const auto leg = straight_path(corners[i - 1], corners[i], 25);
    poses.insert(poses.end(), leg.begin(), leg.end());
  }
  return poses;
}

void MapperTest::load(const Params& more) {
  Params params{{"map_update_interval", 0.1}, {"transform_timeout_s", 2.0}, {"timeout_s", 60.0}};
  for (const auto& [key, value] : more) params[key] = value;
  ASSERT_TRUE(manager_.load("/mapper", "mapper", params)) << log_.text();
  ASSERT_TRUE(wait_for([this] {
    return scans_.getNumSubscribers() > 0 && poses_.connected() && maps_.connected() &&
           transforms_.connected();
  }));
}

void MapperTest::mount_lidar(double roll_rad, double pitch_rad) {
  lidar_roll_rad_ = roll_rad;
  const Pose mount =
      make_pose({base_T_laser_.x, base_T_laser_.y, 0.4}, {roll_rad, pitch_rad, base_T_laser_.yaw});
  static_broadcaster_.sendTransform(ros_convert::to_transform(mount, "base_link", "laser", now_));
}

void MapperTest::publish_odometry(const Pose2& odom_T_base, const ros::Time& stamp) {
  broadcaster_.sendTransform(ros_convert::to_transform(to_pose(odom_T_base), "odom", "base_link", stamp));
}

ros::Time MapperTest::send_scan(const Pose2& room_T_base) {
  const auto stamp = tick();
  auto message = scan_message(compose(room_T_base, base_T_laser_), stamp, {}, seed_++);
  if (std::abs(lidar_roll_rad_) > 1) std::reverse(message->ranges.begin() + 1, message->ranges.end());
  scans_.publish(message);
  return stamp;
}

std::optional<Pose2> MapperTest::answer_at(const ros::Time& stamp) const {
  const auto message = poses_.wait_for_stamp(stamp);
  if (!message) return std::nullopt;
  return ros_convert::to_pose2(message->pose.pose).value();
}

std::optional<Pose2> MapperTest::feed(const Pose2& room_T_base) {
  publish_odometry(compose(odom_T_room_, room_T_base), now_ + ros::Duration(kPeriodS));
  const auto pose = answer_at(send_scan(room_T_base));
  if (pose && !first_in_map_) {
    first_in_map_ = pose;
    first_in_room_ = room_T_base;
  }
  return pose;
}

bool MapperTest::drive(const std::vector<Pose2>& poses) {
  for (const auto& pose : poses)
    if (!feed(pose)) return false;
  return true;
}

double MapperTest::error_m(const Pose2& map_T_base, const Pose2& room_T_base) const {
  const auto moved = between(first_in_map_.value(), map_T_base);
  const auto truth = between(first_in_room_.value(), room_T_base);
  return std::hypot(moved.x - truth.x, moved.y - truth.y);
}

nav_msgs::OccupancyGridConstPtr MapperTest::map() const {
  if (!maps_.wait_for_count(1)) return nullptr;
  return maps_.all().back();
}

nav_msgs::OccupancyGrid MapperTest::map_now() {
  nav_msgs::GetMap call;
  EXPECT_TRUE(ros::service::call("dynamic_map", call));
  return call.response.map;
}

void MapperTest::expect_map_of_the_room(const nav_msgs::OccupancyGrid& map, double tolerance_m) const {
  const auto room_T_map = compose(*first_in_room_, inverse(*first_in_map_));
  std::size_t occupied = 0;
  std::size_t right = 0;
  std::size_t free = 0;
  const double side = static_cast<double>(map.info.resolution);
  for (std::size_t i = 0; i < map.data.size(); ++i) {
    free += map.data[i] >= 0 && map.data[i] < 25;
    if (map.data[i] < 65) continue;
    ++occupied;
    const Pose2 cell{map.info.origin.position.x + (static_cast<double>(i % map.info.width) + 0.5) * side,
                     map.info.origin.position.y + (static_cast<double>(i / map.info.width) + 0.5) * side, 0};
    const auto place = compose(room_T_map, cell);
    right += distance_to_wall(place.x, place.y) < tolerance_m;
  }
  // The walls are 39 m long and the floor has 60 m^2: in cells of 5 cm at least 400 and 16,000.
  EXPECT_GT(occupied, 400U);
  EXPECT_GT(free, 16000U);
  EXPECT_GT(static_cast<double>(right), 0.97 * static_cast<double>(occupied))
      << occupied << " occupied cells";
}

std::optional<geometry_msgs::TransformStamped> MapperTest::last_transform(const std::string& child) const {
  const auto all = transforms_.all();
  for (auto message = all.rbegin(); message != all.rend(); ++message)
    for (const auto& transform : (*message)->transforms)
      if (transform.header.frame_id == "map" && transform.child_frame_id == child) return transform;
  return std::nullopt;
}

}  // namespace extperfc::ros_test
