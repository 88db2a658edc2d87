#pragma once

#include <string>

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/mapping/mapper.hpp"

namespace extperfc::ros_params {

/// Source of the motion prior of scan matching.
enum class OdometrySource {
  kAuto,  ///< tf where it has odom_frame -> base_frame at a scan's stamp, otherwise none
  kTf,    ///< tf; a scan without is dropped
  kNone,  ///< scan matching alone; map -> base_frame is published
};

/// Of the nodelet extperfc/mapper; its class comment names keys, units and ranges.
struct MapperNodeletParams {
  mapping::MapperParams mapper;
  std::string base_frame{"base_link"};
  std::string odom_frame{"odom"};
  std::string map_frame{"map"};
  OdometrySource odometry{OdometrySource::kAuto};
  bool use_imu{false};                       ///< rotation comes from the IMU, translation from odometry
  bool multi_echo{false};                    ///< scan is a sensor_msgs/MultiEchoLaserScan
  int throttle_scans{1};                     ///< use every n-th scan
  int queue_size{10};                        ///< scans that may wait for the worker
  double map_update_interval{5.0};           ///< from map to map, at least [s of wall time]
  double trajectory_interval_s{1.0};         ///< from trajectory to trajectory, at least [s of wall time]
  double transform_publish_period{0.05};     ///< 0: no tf [s]
  double tf_delay{0.05};                     ///< how far ahead tf is stamped [s]
  double transform_timeout_s{0.5};           ///< wait for transforms at the scan's stamp [s of wall time]
  double max_tilt_rad{0.1};                  ///< of the scanner against the floor
  double odometry_max_speed_m_s{5.0};        ///< faster: odometry has jumped
  double odometry_max_yaw_rate_rad_s{10.0};  ///< faster: odometry has jumped
  double timeout_s{5.0};                     ///< silence after which diagnostics warn [s]
  double diagnostic_period{1.0};             ///< [s of wall time]
  std::string session;                       ///< file to resume from; empty: a new map
  bool localization{false};                  ///< in the session's map, which stays as it is
  std::string notice;                        ///< one line about keys of GMapping without effect; empty: none
};

/// Reads `private_handle`; every problem is reported at once.
[[nodiscard]] Result<MapperNodeletParams> load_mapper_params(const ros::NodeHandle& private_handle);

}  // namespace extperfc::ros_params
