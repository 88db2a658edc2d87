#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <std_msgs/Header.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include "extperfc/base/error.hpp"
#include "extperfc/scan/self_filter.hpp"
#include "extperfc/scan/sensor_track.hpp"

#include "ros/params/cloud_to_scan_params.hpp"
#include "ros/scan/imu_tilt.hpp"

namespace extperfc::ros_scan {

/// Poses of one sweep from tf and the IMU.
struct SweepGeometry {
  scan::SensorTrack track;          ///< in the target frame at the cloud's stamp, levelled where it can be
  double tilt_rad{0};               ///< that levelling removed
  double rotation_rad{0};           ///< of the sensor between the track's ends
  std::string not_deskewed;         ///< the reason; empty: deskewed, or not wanted
  std::string not_levelled;         ///< the reason; empty: levelled, or not wanted
  std::vector<std::string> unseen;  ///< frames of the self filter without a transform
};

/// Gathers the poses of a sweep from tf and an IMU. One thread at a time, but for imu().
///
/// Only the transform to the target frame is required. Other missing transforms are reported and left out.
/// The total wait is bounded by transform_tolerance, and frames unknown to tf are not waited for.
class SweepPoses {
 public:
  explicit SweepPoses(const ros_params::CloudToScanNodeletParams& params);

  /// `span` is that of the points' moments, or why there is none. Places `robot` too. Waits until `closing`.
  [[nodiscard]] Result<SweepGeometry> find(const std_msgs::Header& header, const Result<scan::TimeSpan>& span,
                                           scan::SelfFilter& robot, const std::atomic<bool>& closing);

  [[nodiscard]] ImuTilt& imu() { return imu_; }

 private:
  struct Wait;
  struct Ground;

  [[nodiscard]] Result<Pose> lookup(const std::string& target, const std::string& source,
                                    const ros::Time& time, const Wait& wait) const;
  [[nodiscard]] Ground stand(const std_msgs::Header& header, const Wait& wait, SweepGeometry& sweep) const;
  [[nodiscard]] Result<scan::SensorTrack> follow(const std_msgs::Header& header, const scan::TimeSpan& span,
                                                 const Ground& ground, const Wait& wait) const;
  [[nodiscard]] Result<Eigen::Matrix3d> vertical(const std::string& target, const ros::Time& time,
                                                 const Wait& wait) const;
  void transform_robot(const std_msgs::Header& header, const Wait& wait, scan::SelfFilter& robot,
                       SweepGeometry& sweep) const;
  [[nodiscard]] const std::string& target_of(const std_msgs::Header& header) const;

  std::string target_frame_, fixed_frame_;
  bool deskew_;
  ros_params::LevelFrom level_;
  double tolerance_s_;
  std::unique_ptr<tf2_ros::Buffer> buffer_;
  std::unique_ptr<tf2_ros::TransformListener> listener_;
  ImuTilt imu_;
};

}  // namespace extperfc::ros_scan
