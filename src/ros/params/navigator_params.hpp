#pragma once

#include <optional>
#include <string>
#include <vector>

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/navigate/collision_guard.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/global_planner.hpp"
#include "extperfc/navigate/local_planner.hpp"
#include "extperfc/navigate/navigator.hpp"
#include "extperfc/navigate/overhang.hpp"

#include "ros/params/param_reader.hpp"
#include "ros/params/read_footprint.hpp"

namespace extperfc::ros_params {

/// Ages of data [s] beyond which the robot stands.
struct DataLimits {
  double odom_s{0.2};
  double scan_s{0.35};
  double transform_s{0.6};       ///< of global_frame -> odom_frame
  double position_sigma_m{1.0};  ///< standard deviation of amcl_pose beyond which the robot counts as lost
};

/// Cost maps, with costmap_2d's names.
struct CostMapParams {
  double resolution_m{0.05};  ///< of the local map; the global one has that of the map
  double local_size_m{7.0};   ///< side of the local map
  double inflation_radius_m{0.6};
  double cost_scaling_factor{4.0};
  double obstacle_range_m{6.0};
  double raytrace_range_m{8.0};
  double decay_s{20.0};  ///< obstacles that are not seen again are forgotten; 0: never
  double min_obstacle_height_m{0.1};
  double max_obstacle_height_m{1.5};
  double map_margin_m{0.1};  ///< returns nearer to an obstacle of the map are that obstacle
  std::string lidar_frame;   ///< of the lidar whose heights the scan has as intensities; empty: none
  double lidar_half_fov_rad{0.2269};
  bool track_unknown{true};
  double publish_hz{2.0};
  std::string zones_file;  ///< YAML of keep-out and speed zones; empty: none
};

struct ArmOutlineParams {
  bool enabled{true};
  double max_height_m{1.6};  ///< links above do not count
};

struct PeopleParams {
  bool enabled{true};
  double max_range_m{6.0};
  double stand_s{4.0};  ///< who has stood for so long is part of the global cost map
};

struct NavigatorNodeParams {
  std::string global_frame{"map"};
  std::string odom_frame{"odom"};
  std::string base_frame{"base_link"};
  double controller_frequency_hz{20};
  std::string base_global_planner{"extperfc/GridPlanner"};
  std::string base_local_planner{"extperfc/MppiPlanner"};
  FootprintParams footprint;
  navigate::BaseKind base{navigate::BaseKind::kHolonomic};
  navigate::NavigatorParams navigator;
  navigate::GridPlannerParams global;
  navigate::MppiParams local;
  CostMapParams costs;
  DataLimits limits;
  ArmOutlineParams arms;
  PeopleParams people;
  navigate::GuardParams guard;
  double guard_memory_m{0.06};     ///< see navigate::NearMemory
  double timeout_s{5.0};           ///< silence after which diagnostics warn
  std::vector<std::string> notes;  ///< parameters of move_base without effect here; one line each
  std::vector<ReadParam> read;     ///< for dynamic_reconfigure
};

/// Reads `private_handle`; every problem is reported at once.
[[nodiscard]] Result<NavigatorNodeParams> load_navigator_params(const ros::NodeHandle& private_handle);

/// Links that may stick out, from the parameter robot_description above `handle`. Errors: it is not set or no
/// URDF, or has no link robot_base_frame.
[[nodiscard]] Result<navigate::Overhang> load_overhang(const ros::NodeHandle& handle,
                                                       const NavigatorNodeParams& params);

}  // namespace extperfc::ros_params
