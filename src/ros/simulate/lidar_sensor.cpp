#include "ros/simulate/lidar_sensor.hpp"

#include "ros/convert/cloud.hpp"
#include "ros/simulate/frames.hpp"

namespace extperfc::ros_simulate {

Result<std::unique_ptr<LidarSensor>> LidarSensor::make(ros::NodeHandle handle,
                                                       const ros_params::LidarInterfaceParams& params,
                                                       const RobotModel& robot, std::uint64_t seed) {
  const auto link = robot.link(kLidarFrame);
  if (!link)
    return fail(ErrorCode::kNotFound, std::string("the robot has no link ") + kLidarFrame +
                                          ": add it to the URDF, or set lidar/enabled to false");
  return std::unique_ptr<LidarSensor>(new LidarSensor(handle, params, *link, seed));
}

LidarSensor::LidarSensor(ros::NodeHandle& handle, const ros_params::LidarInterfaceParams& params, int link,
                         std::uint64_t seed)
    : params_(params),
      link_(static_cast<std::size_t>(link)),
      publisher_(handle.advertise<sensor_msgs::PointCloud2>("velodyne_points", 4)),
      faults_(seed) {}

bool LidarSensor::measure(simulate::SensorRig& rig, const SensorJob& job) {
  if (!job.before) return true;  // where the sweep began is not known yet
  rig.lidar(params_.lidar, job.before->world_T_link[link_], job.now->world_T_link[link_], points_);
  if (faults_.apply(job.faults, job.now->time_s, points_) == Fate::kLost) return false;
  std_msgs::Header header;
  header.stamp = job.stamp;
  header.frame_id = kLidarFrame;
  publisher_.publish(ros_convert::to_message(points_, 1.0 / params_.lidar.rotation_hz, header));
  return true;
}

}  // namespace extperfc::ros_simulate
