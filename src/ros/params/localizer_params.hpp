#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/localize/localizer.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::ros_params {

/// Standard deviations of the estimate above which diagnostics warn.
struct WarnLevels {
  double x_m{0.2};
  double y_m{0.2};
  double yaw_rad{0.1};
};

struct LocalizerNodeParams {
  localize::LocalizerParams filter;
  std::string odom_frame{"odom"};
  std::string base_frame{"base_link"};
  std::string global_frame{"map"};
  std::string map_file;             ///< a map's YAML file, or .gridmap; empty: from the topic or the service
  bool use_map_topic{false};        ///< false: ask the service static_map
  bool first_map_only{false};       ///< maps of the topic after the first do not count
  bool tf_broadcast{true};          ///< publish global_frame -> odom_frame
  double transform_tolerance{0.1};  ///< how far transforms are dated ahead of their scan [s]
  double tf_timeout_s{0.5};         ///< how long to wait for a transform at the scan's stamp [s]
  Pose2 initial_pose;               ///< of the base in the map
  Eigen::Vector3d initial_variance{0.25, 0.25,
                                   0.0685389};  ///< of x, y, yaw [m^2, m^2, rad^2]: 0.5 m, 15 degrees
  double gui_publish_rate{-1};                  ///< maximum rate of particle clouds [Hz]; -1: one per update
  double save_pose_rate{0.5};  ///< how often the pose goes to the parameter server [Hz]; -1: never
  double idle_update_period_s{
      1.0};              ///< longest time between updates while the robot stands [s]; 0: no such updates
  double lost_fit{0.4};  ///< fraction of fitting beams below which the robot counts as lost [0, 1]
  WarnLevels warn;
  double timeout_s{5.0};  ///< silence of the lidar after which diagnostics warn [s]
  std::vector<std::string>
      notes;  ///< differences from amcl in the meaning of given parameters; one line each
};

/// Reads `private_handle`; every problem is reported at once.
[[nodiscard]] Result<LocalizerNodeParams> load_localizer_params(const ros::NodeHandle& private_handle);

/// Stores a pose where load_localizer_params() finds it as the initial one, and amcl too.
void store_initial_pose(const ros::NodeHandle& private_handle, const Pose2& pose,
                        const Eigen::Matrix3d& covariance);

}  // namespace extperfc::ros_params
