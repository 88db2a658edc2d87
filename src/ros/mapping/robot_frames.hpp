#pragma once

#include <atomic>
#include <optional>
#include <string>

#include <ros/time.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::ros_mapping {

/// Transforms of the robot at a stamp. Waits in wall time, because simulated time may stand still. Every
/// error names the frames, the stamp, and why there is no transform.
class RobotFrames {
 public:
  RobotFrames(std::string base_frame, std::string odom_frame)
      : base_frame_(std::move(base_frame)), odom_frame_(std::move(odom_frame)) {}

  /// Mounting pose of a sensor on the robot.
  [[nodiscard]] Result<Pose> base_T(const std::string& sensor_frame, const ros::Time& stamp,
                                    double timeout_s);
  /// Does not wait for an odometry that has been silent for some scans. One thread at a time.
  [[nodiscard]] Result<Pose2> odom_T_base(const ros::Time& stamp, double timeout_s);

  /// Time ran back to `stamp`: forgets transforms that change, if tf still has later ones.
  void ran_back_to(const ros::Time& stamp, const std::string& sensor_frame);
  /// Ends all waiting.
  void close() { closing_ = true; }

 private:
  [[nodiscard]] Result<Pose> lookup(const std::string& target, const std::string& source,
                                    const ros::Time& stamp, double timeout_s);
  /// Stamp of the newest transform; no value when the frames are not connected.
  [[nodiscard]] std::optional<ros::Time> newest(const std::string& target, const std::string& source) const;
  [[nodiscard]] std::string why_missing(const std::string& target, const std::string& source,
                                        const ros::Time& stamp) const;

  const std::string base_frame_;
  const std::string odom_frame_;
  std::atomic<bool> closing_{false};
  int misses_{0};  ///< of odometry, one after the other
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_{buffer_};
};

}  // namespace extperfc::ros_mapping
