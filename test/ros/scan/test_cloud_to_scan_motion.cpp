// What tf and an IMU add: deskewing, levelling, the robot's own parts; and what happens without them.
#include <functional>

#include <sensor_msgs/Imu.h>
#include <tf2_msgs/TFMessage.h>

#include "ros/convert/geometry.hpp"
#include "test/ros/scan/cloud_to_scan_test.hpp"

namespace extperfc::ros_test {
namespace {

constexpr double kYawRate = 0.5;  // rad/s

class CloudToScanMotionTest : public CloudToScanTest {
 protected:
  void send(const std::string& target, const std::string& source, const Pose& pose, double time_s) {
    tf2_msgs::TFMessage message;
    message.transforms.push_back(
        ros_convert::to_transform(pose, target.c_str(), source.c_str(), ros::Time(time_s)));
    moving_.publish(message);
  }

  /// The base in odom: turning, with roll and pitch, from 10.0 to `until_s`.
  void send_odom(double until_s, double roll = 0, double pitch = 0) {
    // What is sent before the nodelet's listener is connected is lost.
    ASSERT_TRUE(wait_for([this] { return moving_.getNumSubscribers() > 0; }));
    for (int i = 0; 10.0 + 0.02 * i <= until_s + 1e-9; ++i) {
      const double time_s = 10.0 + 0.02 * i;
      send("odom", "base_link", make_pose({1, 2, 0}, {roll, pitch, kYawRate * (time_s - 10.0)}), time_s);
    }
  }

  static Params in_base(Params more = {}) {
    Params params{{"target_frame", "base_link"},
                  {"fixed_frame", "odom"},
                  {"transform_tolerance", 5.0},
                  {"ground_method", "height"}};
    for (auto& [key, value] : more) params[key] = value;
    return params;
  }

  /// The wall x = 3 m, seen by a sensor that turns until the stamp; firing goes clockwise.
  static sensor_msgs::PointCloud2Ptr skewed_wall(double stamp_s) {
    std::vector<CloudPoint> points;
    std::vector<float> times;
    for (int i = 0; i < 400; ++i) {
      const double since_s = -0.1 + 0.1 * i / 399;
      const double direction = 0.8 - 1.6 * i / 399;  // in the base at the stamp
      const double range = 3 / std::cos(direction);
      const double seen = direction - kYawRate * since_s;  // in the sensor at that moment
      for (std::uint16_t ring = 0; ring < 3; ++ring) {
        points.push_back({static_cast<float>(range * std::cos(seen)),
                          static_cast<float>(range * std::sin(seen)), -0.3F + 0.2F * static_cast<float>(ring),
                          50, ring, 0});
        times.push_back(static_cast<float>(since_s));
      }
    }
    auto message = cloud_message(points, ros::Time(stamp_s));
    add_times(*message, times);
    return message;
  }

  /// Greatest distance of ray ends from the wall, over rays that met it.
  static double error_at_wall(const sensor_msgs::LaserScan& scan) {
    double worst = 0;
    int rays = 0;
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const double angle = static_cast<double>(scan.angle_min + static_cast<float>(i) * scan.angle_increment);
      if (!std::isfinite(scan.ranges[i]) || std::abs(angle) > 0.7) continue;
      worst = std::max(worst, std::abs(static_cast<double>(scan.ranges[i]) * std::cos(angle) - 3));
      ++rays;
    }
    EXPECT_GT(rays, 100);
    return worst;
  }

  /// Sends clouds `of` stamps after `stamp_s` until one becomes a scan that is `good`; null when none does.
  /// What was sent before over another connection (tf, an IMU) is there from then on: a cloud may overtake
  /// it.
  sensor_msgs::LaserScanConstPtr flatten_until(
      double& stamp_s, const std::function<sensor_msgs::PointCloud2Ptr(double)>& of,
      const std::function<bool(const sensor_msgs::LaserScan&)>& good) {
    sensor_msgs::LaserScanConstPtr scan;
    const bool found = wait_for([&] {
      scan = flatten(of(stamp_s += 0.0001));
      return scan && good(*scan);
    });
    return found ? scan : nullptr;
  }

  static bool is_straight(const sensor_msgs::LaserScan& scan) {
    return error_at_wall(scan) < 0.03;  // half a bin of half a degree at 40 degrees is 0.016 m
  }

  void send_imu(ros::Publisher& imu, double time_s, double roll, double pitch, double covariance = 0.01) {
    sensor_msgs::Imu message;
    message.header.stamp = ros::Time(time_s);
    message.header.frame_id = "base_link";
    message.orientation = ros_convert::to_quaternion(make_pose({0, 0, 0}, {roll, pitch, 1.0}));
    message.orientation_covariance[0] = covariance;
    imu.publish(message);
  }

  /// The floor, 20 m about a sensor on a base that leans.
  static sensor_msgs::PointCloud2Ptr leaning_floor(double stamp_s, double roll, double pitch) {
    const Pose floor_T_base = make_pose({0, 0, 0}, {roll, pitch, 0});
    const Pose floor_T_sensor = floor_T_base * make_pose({0, 0, kSensorHeightM});
    std::vector<CloudPoint> points;
    for (int i = 0; i < 360; ++i)
      for (std::uint16_t ring = 0; ring < 8; ++ring) {
        const double range = 2 + 1.5 * ring;
        const Eigen::Vector3d on_floor(range * std::cos(i * M_PI / 180), range * std::sin(i * M_PI / 180), 0);
        const Eigen::Vector3f p = (floor_T_sensor.inverse() * on_floor).cast<float>();
        points.push_back({p.x(), p.y(), p.z(), 10, ring, 0});
      }
    return cloud_message(points, ros::Time(stamp_s));
  }

  static int hits(const sensor_msgs::LaserScan& scan) {
    return static_cast<int>(
        std::count_if(scan.ranges.begin(), scan.ranges.end(), [](float r) { return std::isfinite(r); }));
  }

  ros::Publisher moving_{handle_.advertise<tf2_msgs::TFMessage>("/tf", 200)};
};

TEST_F(CloudToScanMotionTest, CloudsOfARotatingRobotAreDeskewed) {
  publish_mount();
  load_and_connect(in_base());
  send_odom(11.0);
  double stamp_s = 10.5;
  EXPECT_TRUE(flatten_until(stamp_s, skewed_wall, is_straight)) << diagnostics_.latest().message();
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) {
    return r.value("deskewed") == "True" && r.value("rotation during the sweep [rad]") == "0.0500" &&
           r.level() == 0;
  })) << diagnostics_.latest().value("rotation during the sweep [rad]");
}

TEST_F(CloudToScanMotionTest, WithoutOdometryTheyAreNotAndItIsSaid) {
  publish_mount();
  load_and_connect(in_base());
  const auto scan = flatten(skewed_wall(10.9));
  ASSERT_TRUE(scan) << "a scan comes all the same";
  EXPECT_GT(error_at_wall(*scan), 0.05);
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) {
    return r.value("deskewed") == "False" &&
           r.is_warning_about("clouds are not deskewed: no transform from base_link to odom");
  }));
}

TEST_F(CloudToScanMotionTest, WithoutTimesTheyAreNotAndItIsSaid) {
  publish_mount();
  load_and_connect(in_base());
  send_odom(11.0);
  EXPECT_TRUE(wait_for([this] {  // a cloud may overtake the odometry, which is another complaint
    cloud_.publish(cloud_message(wall_and_floor(), ros::Time(10.9)));
    return diagnostics_.latest().is_warning_about("clouds are not deskewed: the cloud has no field time");
  })) << diagnostics_.latest().message();
}

TEST_F(CloudToScanMotionTest, OdometryThatComesLateIsWaitedFor) {
  publish_mount();
  load_and_connect(in_base({{"transform_tolerance", 5.0}}));
  send_odom(10.88);
  double stamp_s = 10.5;
  ASSERT_TRUE(flatten_until(stamp_s, skewed_wall, is_straight));  // tf is known from here on
  const std::size_t so_far = scans_->count();
  cloud_.publish(skewed_wall(10.95));
  EXPECT_TRUE(never([&] { return scans_->count() > so_far; })) << "odometry ends before the stamp";
  send("odom", "base_link", make_pose({1, 2, 0}, {0, 0, kYawRate * 1.0}), 11.0);
  const auto scan = scans_->wait_for_stamp(ros::Time(10.95));
  ASSERT_TRUE(scan);
  EXPECT_TRUE(is_straight(*scan)) << error_at_wall(*scan);
}

TEST_F(CloudToScanMotionTest, ALeaningRobotSeesNoObstacleInTheFloor) {
  publish_mount();
  load_and_connect(in_base({{"deskew", false}}));
  send_odom(11.0, 0.03, -0.04);
  const auto floor = [](double at_s) { return leaning_floor(at_s, 0.03, -0.04); };
  const auto is_empty = [](const sensor_msgs::LaserScan& seen) { return hits(seen) == 0; };
  double stamp_s = 10.5;
  const auto scan = flatten_until(stamp_s, floor, is_empty);
  ASSERT_TRUE(scan) << diagnostics_.latest().message();
  const auto nearest = nearest_->wait_for_stamp(scan->header.stamp);
  ASSERT_TRUE(nearest);
  EXPECT_EQ(hits(*nearest), 0);
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.value("tilt [rad]") == "0.0500"; }))
      << diagnostics_.latest().value("tilt [rad]");
  manager_.unload("/cloud_to_scan");
  scans_.reset();
  nearest_.reset();
  load_and_connect(in_base({{"deskew", false}, {"level", "none"}}));
  send_odom(11.0, 0.03, -0.04);
  ASSERT_TRUE(flatten(leaning_floor(10.6, 0.03, -0.04)));
  const auto tilted = nearest_->wait_for_stamp(ros::Time(10.6));
  ASSERT_TRUE(tilted);
  EXPECT_GT(hits(*tilted), 50);
}

TEST_F(CloudToScanMotionTest, AnImuGivesTheVertical) {
  publish_mount();
  auto imu = handle_.advertise<sensor_msgs::Imu>("imu/data", 10);
  Params params{{"target_frame", "base_link"}, {"transform_tolerance", 5.0}, {"level", "imu"}};
  load_and_connect(params);
  ASSERT_TRUE(wait_for([&] { return imu.getNumSubscribers() > 0; }));
  ASSERT_TRUE(flatten(leaning_floor(10.4, 0.03, -0.04)));
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) {
    return r.is_warning_about("clouds are not levelled: no message from the IMU yet");
  }));
  send_imu(imu, 10.45, 0.03, -0.04);
  send_imu(imu, 10.55, 0.03, -0.04);
  // The IMU's messages come in another callback: until they are there, clouds are not levelled.
  double stamp_s = 10.5;
  EXPECT_TRUE(flatten_until(
      stamp_s, [](double at_s) { return leaning_floor(at_s, 0.03, -0.04); },
      [](const sensor_msgs::LaserScan& scan) { return hits(scan) == 0; }));
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.level() == 0; }));
  send_imu(imu, 11.0, 0, 0, -1);
  EXPECT_TRUE(wait_for([&] {
    (void)flatten(leaning_floor(stamp_s += 0.001, 0.03, -0.04));
    return diagnostics_.latest().is_warning_about("the IMU gives no orientation");
  }));
}

TEST_F(CloudToScanMotionTest, TheRobotsOwnArmIsLeftOut) {
  publish_mount();
  XmlRpc::XmlRpcValue volumes;
  volumes[0]["frame"] = "hand";
  volumes[0]["from"] = "0 0 -0.2";
  volumes[0]["to"] = "0 0 0.2";
  volumes[0]["radius"] = 0.1;
  volumes[1]["frame"] = "other_hand";
  volumes[1]["size"] = "0.1 0.1 0.1";
  load_and_connect({{"target_frame", "base_link"}, {"transform_tolerance", 5.0}, {"self_volumes", volumes}});
  auto points = wall_and_floor();
  for (int i = 0; i < 40; ++i)
    points.push_back(
        {1.0F, 0, -0.2F + 0.01F * static_cast<float>(i), 20, static_cast<std::uint16_t>(i % 2), 0});
  const auto seen = flatten(cloud_message(points, ros::Time(10.0)));
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->ranges[360], 1.0, 0.01) << "the pose of the hand is unknown";
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) {
    return r.is_warning_about("the robot itself may be in the scan: no transform of hand, other_hand");
  }));
  send("base_link", "hand", make_pose({1.0, 0, kSensorHeightM}), 10.0);
  send("base_link", "hand", make_pose({1.0, 0, kSensorHeightM}), 11.0);
  double stamp_s = 10.1;
  EXPECT_TRUE(flatten_until(
      stamp_s, [&](double at_s) { return cloud_message(points, ros::Time(at_s)); },
      [](const sensor_msgs::LaserScan& scan) { return std::abs(scan.ranges[360] - 3.0F) < 0.01F; }));
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) {
    return r.number("points on the robot") == 40 && r.is_warning_about("no transform of other_hand");
  }));
}

TEST_F(CloudToScanMotionTest, TwoScansDifferAtASpeckle) {
  publish_mount();
  load_and_connect({{"target_frame", "base_link"}, {"transform_tolerance", 5.0}});
  auto points = wall_and_floor();
  points.push_back({2.0F, 0, 0, 20, 5, 0});
  const auto cloud = cloud_message(points, ros::Time(10.0));
  const auto supported = flatten(cloud);
  ASSERT_TRUE(supported);
  const auto nearest = nearest_->wait_for_stamp(cloud->header.stamp);
  ASSERT_TRUE(nearest);
  EXPECT_NEAR(supported->ranges[360], 3.0, 0.01);
  EXPECT_NEAR(nearest->ranges[360], 2.0, 0.01);
  EXPECT_EQ(supported->header.frame_id, nearest->header.frame_id);
  EXPECT_EQ(supported->ranges.size(), nearest->ranges.size());
}

TEST_F(CloudToScanMotionTest, WrongVolumesAndNamesAreRefusedTogether) {
  XmlRpc::XmlRpcValue volumes;
  volumes[0]["frame"] = "hand";
  volumes[0]["from"] = "0 0";
  volumes[0]["radius"] = 0.1;
  volumes[1]["frame"] = "hand";
  volumes[1]["diameter"] = 0.1;
  EXPECT_FALSE(manager_.load("/cloud_to_scan", "cloud_to_scan",
                             {{"self_volumes", volumes}, {"level", "gravity"}, {"azimuth_times", "middle"}}));
  ASSERT_TRUE(log_.wait("self_volumes"));
  for (const char* text :
       {"self_volumes[0]/from: '0 0' is not three numbers", "self_volumes[1]/diameter: unknown key",
        "'gravity' is unknown", "unknown azimuth_times 'middle'"})
    EXPECT_NE(log_.text().find(text), std::string::npos) << text << "\n" << log_.text();
}

}  // namespace
}  // namespace extperfc::ros_test
