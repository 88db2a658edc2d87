#include "test/ros/navigate/navigator_test.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ros/convert/geometry.hpp"
#include "ros/convert/occupancy_grid.hpp"
#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_test {

namespace {

constexpr double kTickS = 0.02;  // of simulated time
constexpr double kRealTickS = 0.01;
constexpr int kScanTicks = 5;
constexpr std::size_t kRays = 120;
constexpr float kRangeMaxM = 8.0F;
constexpr double kCommandTimeoutS = 0.3;
constexpr float kTableHeightM = 0.72F;

float range_of(const OccupancyGrid& map, const Pose2& from, double angle_rad) {
  constexpr double kMarchM = 0.03;
  for (double range = kMarchM; range < static_cast<double>(kRangeMaxM); range += kMarchM) {
    const auto cell = map.cell_of(from.x + range * std::cos(angle_rad), from.y + range * std::sin(angle_rad));
    if (!cell) break;
    if (map.at(cell->column, cell->row) == OccupancyGrid::kOccupied) return static_cast<float>(range);
  }
  return std::numeric_limits<float>::infinity();
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

/// Time never stands where it stood in an earlier test, nor runs back by itself.
ros::Time& clock_of_all_tests() {
  static ros::Time clock(1000, 0);
  return clock;
}

}  // namespace

void fill(OccupancyGrid& map, const Pose2& low, const Pose2& high) {
  for (std::size_t row = 0; row < map.height; ++row)
    for (std::size_t column = 0; column < map.width; ++column) {
      const Pose2 middle = map.middle_of({column, row});
      if (middle.x > low.x && middle.x < high.x && middle.y > low.y && middle.y < high.y)
        map.cells[row * map.width + column] = OccupancyGrid::kOccupied;
    }
}

OccupancyGrid hall() {
  OccupancyGrid map;
  map.resolution_m = 0.05;
  map.width = 200;
  map.height = 160;
  map.origin = {-5, -4, 0};
  map.cells.assign(map.width * map.height, OccupancyGrid::kFree);
  fill(map, {-5, -4, 0}, {5, -3.9, 0});
  fill(map, {-5, 3.9, 0}, {5, 4, 0});
  fill(map, {-5, -4, 0}, {-4.9, 4, 0});
  fill(map, {4.9, -4, 0}, {5, 4, 0});
  fill(map, {0.9, -4, 0}, {1.1, -0.8, 0});
  fill(map, {0.9, 0.8, 0}, {1.1, 4, 0});
  return map;
}

FakeRobot::FakeRobot() : world_(hall()), now_(clock_of_all_tests()), map_T_odom_{0.3, -0.2, 0.1} {
  odom_T_base_ = compose(inverse(map_T_odom_), {-2, 0, 0});
  ros::Time::setNow(now_);
  subscriber_ = handle_.subscribe<geometry_msgs::Twist>("cmd_vel", 10, [this](const auto& message) {
    const std::lock_guard lock(mutex_);
    command_ = {message->linear.x, message->linear.y, message->angular.z};
    commanded_ = now_;
  });
  thread_ = std::thread([this] { run(); });
}

FakeRobot::~FakeRobot() {
  stopping_ = true;
  thread_.join();
  subscriber_.shutdown();
  clock_of_all_tests() = std::max(clock_of_all_tests(), now_) + ros::Duration(100.0);
}

void FakeRobot::run() {
  auto due = ros::WallTime::now();
  while (!stopping_) {
    step();
    due += ros::WallDuration(kRealTickS);
    const auto left = due - ros::WallTime::now();
    if (left.toSec() > 0)
      left.sleep();
    else
      due = ros::WallTime::now();
  }
}

void FakeRobot::step() {
  Pose2 odom_T_base;
  Pose2 map_T_odom;
  Twist2 velocity;
  ros::Time now;
  {
    const std::lock_guard lock(mutex_);
    now_ += ros::Duration(kTickS);
    if (std::abs((now_ - commanded_).toSec()) > kCommandTimeoutS) command_ = {};
    odom_T_base_ = advance(odom_T_base_, command_, kTickS);
    odom_T_base = odom_T_base_;
    map_T_odom = map_T_odom_;
    velocity = command_;
    now = now_;
  }
  ros::Time::setNow(now);
  if (!odometry_silent_) {
    broadcaster_.sendTransform(
        {transform("map", "odom", map_T_odom, now), transform("odom", "base_link", odom_T_base, now)});
    nav_msgs::Odometry message;
    message.header.stamp = now;
    message.header.frame_id = "odom";
    message.child_frame_id = "base_link";
    message.pose.pose = ros_convert::to_pose_message(odom_T_base);
    message.twist.twist = ros_convert::to_message(velocity);
    odometry_.publish(message);
  }
  if (++ticks_ % kScanTicks == 0 && !scan_silent_) publish_scan(compose(map_T_odom, odom_T_base), now);
}

void FakeRobot::publish_scan(const Pose2& map_T_base, const ros::Time& stamp) {
  OccupancyGrid world;
  std::optional<OccupancyGrid> table;
  {
    const std::lock_guard lock(mutex_);
    world = world_;
    table = table_;
  }
  sensor_msgs::LaserScan scan;
  scan.header.stamp = stamp;
  scan.header.frame_id = "base_link";
  scan.angle_min = static_cast<float>(-M_PI);
  scan.angle_increment = static_cast<float>(2 * M_PI / kRays);
  scan.angle_max = scan.angle_min + scan.angle_increment * static_cast<float>(kRays - 1);
  scan.range_min = 0.05F;
  scan.range_max = kRangeMaxM;
  scan.ranges.reserve(kRays);
  for (std::size_t i = 0; i < kRays; ++i) {
    const double angle = map_T_base.yaw + static_cast<double>(scan.angle_min) +
                         static_cast<double>(i) * static_cast<double>(scan.angle_increment);
    scan.ranges.push_back(range_of(world, map_T_base, angle));
    if (!table) continue;
    const float to_table_m = range_of(*table, map_T_base, angle);
    const bool shown = to_table_m > kTableFromM && to_table_m < scan.ranges.back();
    if (shown) scan.ranges.back() = to_table_m;
    scan.intensities.push_back(shown ? kTableHeightM : 0.0F);
  }
  scan_.publish(scan);
}

Pose2 FakeRobot::pose() const {
  const std::lock_guard lock(mutex_);
  return compose(map_T_odom_, odom_T_base_);
}

Pose2 FakeRobot::odom_T_map() const {
  const std::lock_guard lock(mutex_);
  return inverse(map_T_odom_);
}

Twist2 FakeRobot::velocity() const {
  const std::lock_guard lock(mutex_);
  return command_;
}

ros::Time FakeRobot::now() const {
  const std::lock_guard lock(mutex_);
  return now_;
}

void FakeRobot::set_world(const OccupancyGrid& world) {
  const std::lock_guard lock(mutex_);
  world_ = world;
}

void FakeRobot::set_table(const OccupancyGrid& table) {
  const std::lock_guard lock(mutex_);
  table_ = table;
}

void FakeRobot::put(const Pose2& map_T_base) {
  const std::lock_guard lock(mutex_);
  map_T_odom_ = compose(map_T_base, inverse(odom_T_base_));
}

void FakeRobot::jump_odometry(const Pose2& by) {
  const std::lock_guard lock(mutex_);
  const auto map_T_base = compose(map_T_odom_, odom_T_base_);
  odom_T_base_ = compose(by, odom_T_base_);
  map_T_odom_ = compose(map_T_base, inverse(odom_T_base_));
}

void FakeRobot::jump_clock(double seconds) {
  const std::lock_guard lock(mutex_);
  now_ += ros::Duration(seconds);
  commanded_ = now_;
}

double FakeRobot::seconds_until_it_stands() const {
  const auto since = now();
  const auto stands = [&] {
    const auto v = velocity();
    return v.vx == 0 && v.vy == 0 && v.wz == 0;
  };
  const auto deadline = ros::WallTime::now() + ros::WallDuration(5.0);
  while (ros::WallTime::now() < deadline) {
    if (stands()) return (now() - since).toSec();
    ros::WallDuration(0.001).sleep();
  }
  return -1;
}

Params NavigatorTest::params() {
  return {{"footprint", std::string("[[0.3, 0.25], [-0.3, 0.25], [-0.3, -0.25], [0.3, -0.25]]")},
          {"arm_outline", false},
          {"wait_s", 0.5},
          {"planner_patience", 1.0},
          {"data_patience_s", 60.0}};
}

void NavigatorTest::load(const Params& more) {
  publish_map(map_);
  auto all = params();
  for (const auto& [key, value] : more) all[key] = value;
  ASSERT_TRUE(manager_.load("/navigator", "navigator", all)) << log_.text();
  ASSERT_TRUE(wait_for([&] { return client_.isServerConnected(); }));
  ASSERT_TRUE(wait_for([&] { return status_.count() > 3 && commands_.connected(); })) << log_.text();
}

void NavigatorTest::publish_map(const OccupancyGrid& map) {
  std_msgs::Header header;
  header.frame_id = "map";
  map_publisher_.publish(ros_convert::to_message(map, header));
}

move_base_msgs::MoveBaseGoal NavigatorTest::goal(double x, double y, double yaw, const std::string& frame) {
  move_base_msgs::MoveBaseGoal goal;
  goal.target_pose.header.frame_id = frame;
  goal.target_pose.pose = ros_convert::to_pose_message({x, y, yaw});
  return goal;
}

bool NavigatorTest::wait_for_end(double patience_s) {
  return wait_for([&] { return client_.getState().isDone(); }, patience_s);
}

bool NavigatorTest::wait_until_it_drives() const {
  return wait_for([&] { return robot_.velocity().vx > 0.25; });
}

std::string NavigatorTest::last_state() const {
  const auto all = status_.all();
  return all.empty() ? "" : all.back()->state;
}

}  // namespace extperfc::ros_test
