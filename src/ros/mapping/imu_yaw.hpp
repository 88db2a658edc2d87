#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

#include <Eigen/Core>
#include <sensor_msgs/Imu.h>

#include "extperfc/world/pose.hpp"

namespace extperfc::ros_mapping {

/// The base's yaw by an IMU: from its orientation, or from its angular velocity when it gives no orientation
/// (orientation_covariance[0] = -1). Only differences are meaningful. Thread-safe, bounded.
class ImuYaw {
 public:
  /// Keeps a sample. Older stamps than the last clear the buffer; samples that are not finite are ignored and
  /// counted.
  void add(const sensor_msgs::Imu& message);

  /// Unwrapped yaw [rad] at a stamp, between its neighbours. Waits up to `timeout_s` of wall time for the
  /// later one; no value when it does not come, or when the stamp is older than the buffer.
  [[nodiscard]] std::optional<double> at(double stamp_s, double timeout_s);

  /// Frame of the samples that have no mount yet; empty: none.
  [[nodiscard]] std::string unknown_frame() const;
  /// Mounting pose of the IMU on the robot; level and upright until then. Clears the buffer when it changes.
  void set_mount(const std::string& frame, const Pose& base_T_imu);

  /// Ends all waiting.
  void close();
  [[nodiscard]] std::size_t received() const;
  [[nodiscard]] std::size_t ignored() const;

 private:
  static constexpr std::size_t kKept = 4000;   ///< samples: 10 s at 400 Hz
  static constexpr double kLongestGapS = 0.5;  ///< no interpolation between samples farther apart

  struct Sample {
    double stamp_s;
    double yaw_rad;
    double rate_rad_s;
  };

  [[nodiscard]] std::optional<double> interpolate(double stamp_s) const;

  mutable std::mutex mutex_;
  std::condition_variable newer_;
  std::deque<Sample> samples_;
  std::string frame_;
  bool mounted_{false};
  Eigen::Matrix3d base_R_imu_{Eigen::Matrix3d::Identity()};
  std::size_t received_{0};
  std::size_t ignored_{0};
  bool closed_{false};
};

}  // namespace extperfc::ros_mapping
