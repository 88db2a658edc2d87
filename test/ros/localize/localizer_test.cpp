#include "test/ros/localize/localizer_test.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ros/convert/occupancy_grid.hpp"
#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_test {

namespace {

constexpr double kStepS = 0.1;
constexpr std::size_t kRays = 180;
constexpr float kRangeMaxM = 12.0F;

/// Time never stands where it stood in an earlier test, nor runs back by itself.
ros::Time& clock_of_all_tests() {
  static ros::Time clock(1000, 0);
  return clock;
}

void fill(OccupancyGrid& map, const Pose2& low, const Pose2& high) {
  for (std::size_t row = 0; row < map.height; ++row)
    for (std::size_t column = 0; column < map.width; ++column) {
      const Pose2 middle = map.middle_of({column, row});
      if (middle.x > low.x && middle.x < high.x && middle.y > low.y && middle.y < high.y)
        map.cells[row * map.width + column] = OccupancyGrid::kOccupied;
    }
}

OccupancyGrid walled(double width_m, double height_m) {
  constexpr double kWallM = 0.1;
  OccupancyGrid map;
  map.resolution_m = 0.05;
  map.width = static_cast<std::size_t>(std::lround(width_m / map.resolution_m));
  map.height = static_cast<std::size_t>(std::lround(height_m / map.resolution_m));
  map.origin = {-width_m / 2, -height_m / 2, 0};
  map.cells.assign(map.width * map.height, OccupancyGrid::kFree);
  const double x = width_m / 2;
  const double y = height_m / 2;
  fill(map, {-x, -y, 0}, {x, -y + kWallM, 0});
  fill(map, {-x, y - kWallM, 0}, {x, y, 0});
  fill(map, {-x, -y, 0}, {-x + kWallM, y, 0});
  fill(map, {x - kWallM, -y, 0}, {x, y, 0});
  return map;
}

geometry_msgs::TransformStamped transform(const std::string& target, const std::string& source,
                                          const Pose2& pose, const ros::Time& stamp) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = target;
  message.child_frame_id = source;
  message.transform = ros_convert::to_transform_message(pose);
  return message;
}

float range_of(const OccupancyGrid& map, const Pose2& from, double angle_rad) {
  constexpr double kMarchM = 0.01;
  for (double range = kMarchM; range < kRangeMaxM; range += kMarchM) {
    const auto cell = map.cell_of(from.x + range * std::cos(angle_rad), from.y + range * std::sin(angle_rad));
    if (!cell) break;
    if (map.at(cell->column, cell->row) == OccupancyGrid::kOccupied) return static_cast<float>(range);
  }
  return std::numeric_limits<float>::infinity();
}

}  // namespace

OccupancyGrid furnished_room() {
  auto map = walled(8, 6);
  fill(map, {0.5, -3, 0}, {0.6, -0.8, 0});    // partition
  fill(map, {1.9, 1.0, 0}, {3.1, 1.7, 0});    // cupboard
  fill(map, {-2.7, 1.4, 0}, {-2.3, 1.8, 0});  // pillar
  fill(map, {-4, -2.0, 0}, {-3.2, -1.2, 0});  // niche
  return map;
}

OccupancyGrid bare_hall() {
  return walled(16, 12);
}

sensor_msgs::LaserScan cast(const OccupancyGrid& map, const Pose2& map_T_scanner, const std::string& frame,
                            const ros::Time& stamp) {
  sensor_msgs::LaserScan scan;
  scan.header.stamp = stamp;
  scan.header.frame_id = frame;
  scan.angle_min = static_cast<float>(-M_PI);
  scan.angle_increment = static_cast<float>(2 * M_PI / kRays);
  scan.angle_max = scan.angle_min + scan.angle_increment * static_cast<float>(kRays - 1);
  scan.range_min = 0.05F;
  scan.range_max = kRangeMaxM;
  for (std::size_t i = 0; i < kRays; ++i)
    scan.ranges.push_back(range_of(map, map_T_scanner,
                                   map_T_scanner.yaw + static_cast<double>(scan.angle_min) +
                                       static_cast<double>(i) * static_cast<double>(scan.angle_increment)));
  return scan;
}

double yaw_difference_rad(const Pose2& a, const Pose2& b) {
  return std::abs(wrap_angle(a.yaw - b.yaw));
}

LocalizerTest::LocalizerTest() : now_(clock_of_all_tests()) {
  ros::Time::setNow(now_);
}

LocalizerTest::~LocalizerTest() {
  clock_of_all_tests() = std::max(clock_of_all_tests(), now_) + ros::Duration(100.0);
}

Params LocalizerTest::params() {
  return {{"use_map_topic", true},  {"save_pose_rate", -1.0}, {"idle_update_period_s", 0.0},
          {"update_min_d", 0.15},   {"update_min_a", 0.15},   {"transform_tolerance", 0.25},
          {"laser_sigma_hit", 0.1}, {"tf_timeout_s", 5.0},    {"odom_alpha1", 0.01},
          {"odom_alpha2", 0.01},    {"odom_alpha3", 0.01},    {"odom_alpha4", 0.01},
          {"initial_cov_xx", 0.04}, {"initial_cov_yy", 0.04}, {"initial_cov_aa", 0.02}};
}

void LocalizerTest::load(const Params& more) {
  publish_map(room_);
  load_without_map(more);
  ASSERT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.value("map") == "loaded"; }));
}

void LocalizerTest::load_without_map(const Params& more) {
  auto all = params();
  for (const auto& [key, value] : more) all[key] = value;
  publish_mount(scanner_frame_, base_T_scanner_);
  ASSERT_TRUE(manager_.load("/localizer", "localizer", all)) << log_.text();
  ASSERT_TRUE(wait_for([&] {
    return scan_.getNumSubscribers() > 0 && initialpose_.getNumSubscribers() > 0 && poses_.connected() &&
           tf_.connected();
  }));
}

void LocalizerTest::publish_map(const OccupancyGrid& map) {
  std_msgs::Header header;
  header.frame_id = "map";
  map_.publish(ros_convert::to_message(map, header));
}

void LocalizerTest::publish_mount(const std::string& frame, const Pose2& base_T_scanner, bool upside_down) {
  auto mount = transform("base_link", frame, base_T_scanner, now_);
  if (upside_down) {  // rotation by pi about x before the yaw
    const auto q = mount.transform.rotation;
    mount.transform.rotation.x = q.w;
    mount.transform.rotation.y = q.z;
    mount.transform.rotation.z = mount.transform.rotation.w = 0;
  }
  static_broadcaster_.sendTransform(mount);
}

void LocalizerTest::broadcast_odometry() {
  ros::Time::setNow(now_);
  broadcaster_.sendTransform(
      transform("odom", "base_link", compose(inverse(map_T_odom_), map_T_base_), now_));
}

void LocalizerTest::tick() {
  now_ += ros::Duration(kStepS);
  broadcast_odometry();
  scan_.publish(cast(seen_, compose(map_T_base_, base_T_scanner_), scanner_frame_, now_));
}

std::vector<geometry_msgs::TransformStamped> LocalizerTest::transforms() const {
  std::vector<geometry_msgs::TransformStamped> found;
  for (const auto& message : tf_.all())
    for (const auto& one : message->transforms)
      if (one.header.frame_id == "map" && one.child_frame_id == "odom") found.push_back(one);
  return found;
}

std::optional<Pose2> LocalizerTest::locate() {
  const auto before = transforms().size();
  tick();
  if (!wait_for([&] { return transforms().size() > before; })) return std::nullopt;
  const auto map_T_odom = ros_convert::to_pose2(transforms().back().transform);
  return compose(map_T_odom.value(), compose(inverse(map_T_odom_), map_T_base_));
}

std::optional<Pose2> LocalizerTest::drive(double distance_m, double rotation_rad, int steps) {
  std::optional<Pose2> pose;
  for (int i = 0; i < steps; ++i) {
    map_T_base_ = compose(map_T_base_, {distance_m / steps, 0, rotation_rad / steps});
    pose = locate();
    if (!pose) return pose;
  }
  return pose;
}

std::optional<Pose2> LocalizerTest::drive_around() {
  std::optional<Pose2> pose;
  for (int side = 0; side < 4; ++side) {
    if (!drive(0.8, 0, 4)) return std::nullopt;
    pose = drive(0, M_PI / 2, 6);
    if (!pose) return pose;
  }
  return pose;
}

void LocalizerTest::give_pose(const Pose2& pose, double sigma_m, double sigma_rad, const std::string& frame,
                              std::optional<ros::Time> stamp) {
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header.frame_id = frame;
  message.header.stamp = stamp.value_or(now_);
  message.pose.pose = ros_convert::to_pose_message(pose);
  message.pose.covariance = ros_convert::to_covariance_message(
      Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad).asDiagonal());
  initialpose_.publish(message);
}

bool LocalizerTest::tick_until(const std::function<bool()>& condition) {
  return wait_for([&] {
    tick();
    return wait_for(condition, 0.03);
  });
}

void LocalizerTest::expect_near(const Pose2& estimate, double error_m, double error_rad) const {
  EXPECT_LT(distance_m(estimate, map_T_base_), error_m)
      << estimate.x << " " << estimate.y << " instead of " << map_T_base_.x << " " << map_T_base_.y;
  EXPECT_LT(yaw_difference_rad(estimate, map_T_base_), error_rad)
      << estimate.yaw << " instead of " << map_T_base_.yaw;
}

}  // namespace extperfc::ros_test
