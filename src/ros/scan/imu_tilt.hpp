#pragma once

#include <deque>
#include <mutex>
#include <optional>
#include <string>

#include <Eigen/Geometry>
#include <ros/time.h>
#include <sensor_msgs/Imu.h>

#include "extperfc/base/error.hpp"

namespace extperfc::ros_scan {

/// The latest orientations of an IMU, by time. Thread-safe.
class ImuTilt {
 public:
  void add(const sensor_msgs::Imu& message);

  /// world_R_imu at a time, interpolated; the newest one where it is no more than 0.1 s older. Errors: no
  /// message yet, an IMU without orientation, messages that are too old or too new.
  [[nodiscard]] Result<Eigen::Quaterniond> at(const ros::Time& time) const;

  /// Of the latest message; empty before the first.
  [[nodiscard]] std::string frame() const;

 private:
  struct Sample {
    ros::Time time;
    Eigen::Quaterniond world_R_imu;
  };
  static constexpr std::size_t kKept = 512;  ///< 1.3 s at 400 Hz

  mutable std::mutex mutex_;
  std::deque<Sample> samples_;  ///< in order of time
  std::string frame_;
  bool without_orientation_{false};
};

}  // namespace extperfc::ros_scan
