#pragma once

#include <memory>
#include <vector>

#include <ros/node_handle.h>

#include "ros/params/simulator_params.hpp"
#include "ros/simulate/sensor.hpp"
#include "ros/simulate/sensor_faults.hpp"

namespace extperfc::ros_simulate {

/// The VLP-16, as velodyne_pointcloud shows it. The first sweep comes one revolution after the first
/// subscriber.
///
/// Publishes:
///   velodyne_points  sensor_msgs/PointCloud2 in the frame `velodyne`: x y z intensity float32, ring uint16,
///                    time float32; 22 bytes a point, unordered. The stamp is that of the end of the sweep,
///                    and stamp + time is when a point was measured: times lie in (-0.1, 0] s at 10 Hz.
///                    Points are in the sensor's frame at their own time
class LidarSensor : public Sensor {
 public:
  /// Errors: the robot has no lidar frame.
  [[nodiscard]] static Result<std::unique_ptr<LidarSensor>> make(
      ros::NodeHandle handle, const ros_params::LidarInterfaceParams& params, const RobotModel& robot,
      std::uint64_t seed);

  [[nodiscard]] const char* name() const override { return "lidar"; }
  [[nodiscard]] double rate_hz() const override { return params_.lidar.rotation_hz; }
  [[nodiscard]] bool wanted() const override { return publisher_.getNumSubscribers() > 0; }
  bool measure(simulate::SensorRig& rig, const SensorJob& job) override;

 private:
  LidarSensor(ros::NodeHandle& handle, const ros_params::LidarInterfaceParams& params, int link,
              std::uint64_t seed);

  const ros_params::LidarInterfaceParams params_;
  const std::size_t link_;
  ros::Publisher publisher_;
  LidarFaults faults_;
  std::vector<simulate::LidarPoint> points_;
};

}  // namespace extperfc::ros_simulate
