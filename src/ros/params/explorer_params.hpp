#pragma once

#include <string>

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/navigate/frontiers.hpp"

#include "ros/params/read_footprint.hpp"

namespace extperfc::ros_params {

struct ExplorerParams {
  std::string base_frame{"base_link"};  ///< of the footprint
  FootprintParams footprint{{}, 0.46, 0.05};
  navigate::FrontierParams frontiers;
  double map_patience_s{10};        ///< wait for a map that is newer than the arrival at a goal
  double navigator_patience_s{10};  ///< wait for the action server move_base
  double transform_timeout_s{1};    ///< wait for the robot's pose
  double goal_timeout_s{180};       ///< a goal that takes longer counts as failed
};

/// Reads `private_handle`; every problem is reported at once.
[[nodiscard]] Result<ExplorerParams> load_explorer_params(const ros::NodeHandle& private_handle);

}  // namespace extperfc::ros_params
