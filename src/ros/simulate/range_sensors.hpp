#pragma once

#include <memory>
#include <vector>

#include <ros/node_handle.h>

#include "extperfc/simulate/robot_io.hpp"

#include "ros/params/simulator_params.hpp"
#include "ros/simulate/sensor.hpp"

namespace extperfc::ros_simulate {

/// The infrared sensors in Baxter's hands.
///
/// Publishes:
///   robot/range/<side>_hand_range/state  sensor_msgs/Range, 0.004 to 0.4 m, frame <side>_hand_range; as the
///                                        robot does, 65.535 m when no object is in range
class HandRangeSensor : public Sensor {
 public:
  /// Errors: the robot has no such frame.
  [[nodiscard]] static Result<std::unique_ptr<HandRangeSensor>> make(ros::NodeHandle handle, double rate_hz,
                                                                     simulate::Side side,
                                                                     const RobotModel& robot);

  [[nodiscard]] const char* name() const override { return name_.c_str(); }
  [[nodiscard]] double rate_hz() const override { return rate_hz_; }
  [[nodiscard]] bool wanted() const override { return publisher_.getNumSubscribers() > 0; }
  bool measure(simulate::SensorRig& rig, const SensorJob& job) override;

 private:
  HandRangeSensor(ros::NodeHandle& handle, double rate_hz, std::string name, int link);

  const std::string name_;
  const double rate_hz_;
  const std::size_t link_;
  ros::Publisher publisher_;
};

/// The twelve sonars around Baxter's head.
///
/// Publishes:
///   robot/sonar/head_sonar/state  sensor_msgs/PointCloud in the frame sonar_ring: where the echoes come
///                                 from; channels SensorId and Distance [m]; sensors without an echo are left
///                                 out
class SonarSensor : public Sensor {
 public:
  /// Errors: the robot has no such frame.
  [[nodiscard]] static Result<std::unique_ptr<SonarSensor>> make(ros::NodeHandle handle, double rate_hz,
                                                                 const RobotModel& robot);

  [[nodiscard]] const char* name() const override { return "head_sonar"; }
  [[nodiscard]] double rate_hz() const override { return rate_hz_; }
  [[nodiscard]] bool wanted() const override { return publisher_.getNumSubscribers() > 0; }
  bool measure(simulate::SensorRig& rig, const SensorJob& job) override;

 private:
  SonarSensor(ros::NodeHandle& handle, double rate_hz, int link);

  const double rate_hz_;
  const std::size_t link_;
  ros::Publisher publisher_;
};

}  // namespace extperfc::ros_simulate
