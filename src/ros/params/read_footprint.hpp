#pragma once

#include <vector>

#include <Eigen/Core>
#include <ros/node_handle.h>

#include "extperfc/navigate/footprint.hpp"

#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

/// costmap_2d's parameters of the robot's outline.
struct FootprintParams {
  std::vector<Eigen::Vector2d> corners_m;  ///< in the base's frame; empty: a circle of radius_m
  double radius_m{0.46};
  double padding_m{0.02};

  [[nodiscard]] navigate::Footprint outline() const;  ///< without padding
  [[nodiscard]] navigate::Footprint padded() const { return outline().padded(padding_m); }
};

/// Reads footprint ("[[0.4, 0.3], ...]" as costmap_2d has it, or a list of lists), robot_radius and
/// footprint_padding.
void read_footprint(ParamReader& reader, const ros::NodeHandle& handle, FootprintParams& params);

}  // namespace extperfc::ros_params
