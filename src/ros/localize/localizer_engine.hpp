#pragma once

#include <atomic>
#include <optional>
#include <string>

#include <tf2_ros/buffer.h>

#include "extperfc/base/error.hpp"
#include "extperfc/localize/localizer.hpp"

#include "ros/localize/localizer_inbox.hpp"
#include "ros/params/localizer_params.hpp"

namespace extperfc::ros_localize {

/// Result of one scan.
struct Located {
  ros::Time stamp;                  ///< of the scan
  Pose2 map_T_odom;                 ///< holds until the next update
  Pose2 map_T_base;                 ///< at the scan's stamp
  bool updated{false};              ///< false: the robot stood, the pose follows odometry
  localize::PoseEstimate estimate;  ///< of the last update
};

/// The localizer with its transforms: turns work into poses. One thread at a time; stop() from any.
class LocalizerEngine {
 public:
  LocalizerEngine(const ros_params::LocalizerNodeParams& params, tf2_ros::Buffer& tf);

  /// No value: no map yet, or no scan in the work. Errors: unusable scans and transforms, each named.
  [[nodiscard]] Result<std::optional<Located>> process(const Work& work);

  [[nodiscard]] bool has_map() const { return localizer_.has_value(); }
  /// Empty before the first map.
  [[nodiscard]] const std::vector<localize::Particle>& particles() const;
  void stop() { stopped_ = true; }

 private:
  struct Odometry {
    ros::Time stamp;
    Pose2 odom_T_base;
  };

  Result<void> take_map(const MapPtr& map);
  Result<Located> locate(const sensor_msgs::LaserScan& message);
  Result<Pose2> odometry_at(const ros::Time& stamp);
  Result<Pose> transform_at(const std::string& target, const std::string& source, const ros::Time& stamp);
  Result<void> place(const Odometry& now);
  Result<void> place(const GivenPose& given, const Odometry& now);
  Result<void> keep_pose(const Odometry& now);
  [[nodiscard]] bool jumped(const Odometry& now) const;
  [[nodiscard]] bool update_is_due(const ros::Time& stamp) const;

  const ros_params::LocalizerNodeParams params_;
  tf2_ros::Buffer& tf_;
  std::atomic<bool> stopped_{false};
  std::optional<localize::Localizer> localizer_;
  std::optional<Placement> placement_;  ///< to be applied with the next scan
  bool force_{false};
  bool time_ran_back_{false};
  std::optional<Odometry> last_;  ///< of the last scan
  std::optional<ros::Time> last_update_;
  Pose2 map_T_odom_;
};

}  // namespace extperfc::ros_localize
