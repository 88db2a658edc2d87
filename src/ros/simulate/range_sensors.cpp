#include "ros/simulate/range_sensors.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <sensor_msgs/PointCloud.h>
#include <sensor_msgs/Range.h>

#include "extperfc/base/math.hpp"

#include "ros/simulate/frames.hpp"

namespace extperfc::ros_simulate {

namespace {

constexpr double kHandMinM = 0.004;
constexpr double kHandMaxM = 0.4;
constexpr double kHandHalfAngleRad = 0.0436;
constexpr float kNothingInRangeM = 65.535F;

constexpr int kSonars = 12;
constexpr double kSonarRingM = 0.10;  ///< radius of the ring that the sonars sit on
constexpr double kSonarMaxM = 10.0;
constexpr double kSonarHalfAngleRad = 0.2;

Result<int> link_of(const RobotModel& robot, const std::string& name) {
  if (const auto link = robot.link(name)) return *link;
  return fail(ErrorCode::kNotFound,
              "the robot has no link " + name + ": add it to the URDF, or set range/enabled to false");
}

}  // namespace

Result<std::unique_ptr<HandRangeSensor>> HandRangeSensor::make(ros::NodeHandle handle, double rate_hz,
                                                               simulate::Side side, const RobotModel& robot) {
  const std::string name = std::string(simulate::to_string(side)) + "_hand_range";
  const auto link = link_of(robot, name);
  if (!link) return tl::unexpected(link.error());
  return std::unique_ptr<HandRangeSensor>(new HandRangeSensor(handle, rate_hz, name, *link));
}

HandRangeSensor::HandRangeSensor(ros::NodeHandle& handle, double rate_hz, std::string name, int link)
    : name_(std::move(name)),
      rate_hz_(rate_hz),
      link_(static_cast<std::size_t>(link)),
      publisher_(handle.advertise<sensor_msgs::Range>("robot/range/" + name_ + "/state", 4)) {}

bool HandRangeSensor::measure(simulate::SensorRig& rig, const SensorJob& job) {
  const double distance_m = rig.range(job.now->world_T_link[link_], kHandHalfAngleRad, kHandMaxM);
  const auto message = boost::make_shared<sensor_msgs::Range>();
  message->header.stamp = job.stamp;
  message->header.frame_id = name_;
  message->radiation_type = sensor_msgs::Range::INFRARED;
  message->field_of_view = static_cast<float>(2 * kHandHalfAngleRad);
  message->min_range = static_cast<float>(kHandMinM);
  message->max_range = static_cast<float>(kHandMaxM);
  message->range =
      distance_m <= kHandMaxM ? static_cast<float>(std::max(distance_m, kHandMinM)) : kNothingInRangeM;
  publisher_.publish(message);
  return true;
}

Result<std::unique_ptr<SonarSensor>> SonarSensor::make(ros::NodeHandle handle, double rate_hz,
                                                       const RobotModel& robot) {
  const auto link = link_of(robot, kSonarFrame);
  if (!link) return tl::unexpected(link.error());
  return std::unique_ptr<SonarSensor>(new SonarSensor(handle, rate_hz, *link));
}

SonarSensor::SonarSensor(ros::NodeHandle& handle, double rate_hz, int link)
    : rate_hz_(rate_hz),
      link_(static_cast<std::size_t>(link)),
      publisher_(handle.advertise<sensor_msgs::PointCloud>("robot/sonar/head_sonar/state", 4)) {}

bool SonarSensor::measure(simulate::SensorRig& rig, const SensorJob& job) {
  const auto message = boost::make_shared<sensor_msgs::PointCloud>();
  message->header.stamp = job.stamp;
  message->header.frame_id = kSonarFrame;
  message->channels.resize(2);
  message->channels[0].name = "SensorId";
  message->channels[1].name = "Distance";
  for (int i = 0; i < kSonars; ++i) {
    const double angle = 2 * kPi * i / kSonars;
    const auto ring_T_sonar =
        make_pose({kSonarRingM * std::cos(angle), kSonarRingM * std::sin(angle), 0}, {0, 0, angle});
    const double distance_m =
        rig.range(job.now->world_T_link[link_] * ring_T_sonar, kSonarHalfAngleRad, kSonarMaxM);
    if (distance_m > kSonarMaxM) continue;
    geometry_msgs::Point32 point;
    point.x = static_cast<float>((kSonarRingM + distance_m) * std::cos(angle));
    point.y = static_cast<float>((kSonarRingM + distance_m) * std::sin(angle));
    message->points.push_back(point);
    message->channels[0].values.push_back(static_cast<float>(i));
    message->channels[1].values.push_back(static_cast<float>(distance_m));
  }
  publisher_.publish(message);
  return true;
}

}  // namespace extperfc::ros_simulate
