#include "ros/params/explorer_params.hpp"

#include <exception>

#include <yaml-cpp/yaml.h>

#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

namespace {

/// "[[0.4, 0.3], ...]" as costmap_2d has it.
void read_footprint(ParamReader& reader, ExplorerParams& params) {
  std::string text;
  reader.read("footprint", text);
  if (text.empty()) return;
  try {
    for (const auto& corner : YAML::Load(text))
      params.footprint_m.emplace_back(corner[0].as<double>(), corner[1].as<double>());
  } catch (const std::exception&) {
    params.footprint_m.clear();
    return reader.complain("footprint must be a text with a list of corners [[x, y], ...] in m");
  }
  if (const auto made = navigate::Footprint::make(params.footprint_m); !made)
    reader.complain(made.error().message);
}

void read_frontiers(ParamReader& reader, navigate::FrontierParams& frontiers) {
  reader.read("min_frontier_m", frontiers.min_length_m, {0.01, 100.0});
  reader.read("max_frontier_m", frontiers.max_length_m, {0.01, 1000.0});
  reader.read("gain_weight", frontiers.gain_weight, {0.0, 1000.0});
  reader.read("max_standoff_m", frontiers.max_standoff_m, {0.1, 20.0});
  reader.read("start_tolerance_m", frontiers.start_tolerance_m, {0.0, 10.0});
  reader.read("blacklist_radius_m", frontiers.blacklist_radius_m, {0.01, 100.0});
  reader.read("allow_unknown", frontiers.allow_unknown);
  if (frontiers.max_length_m < frontiers.min_length_m)
    reader.complain("max_frontier_m must not be less than min_frontier_m");
}

}  // namespace

navigate::Footprint ExplorerParams::outline() const {
  const auto outline = footprint_m.empty() ? navigate::Footprint::circle(robot_radius_m)
                                           : *navigate::Footprint::make(footprint_m);
  return outline.padded(footprint_padding_m);
}

Result<ExplorerParams> load_explorer_params(const ros::NodeHandle& private_handle) {
  ExplorerParams params;
  ParamReader reader(private_handle);
  reader.read("robot_base_frame", params.base_frame);
  read_footprint(reader, params);
  reader.read("robot_radius", params.robot_radius_m, {0.01, 9.0});
  reader.read("footprint_padding", params.footprint_padding_m, {0.0, 1.0});
  read_frontiers(reader, params.frontiers);
  reader.read("map_patience_s", params.map_patience_s, {0.1, 3600.0});
  reader.read("navigator_patience_s", params.navigator_patience_s, {0.1, 3600.0});
  reader.read("transform_timeout_s", params.transform_timeout_s, {0.0, 60.0});
  reader.read("goal_timeout_s", params.goal_timeout_s, {1.0, 1e5});
  if (params.base_frame.empty()) reader.complain("robot_base_frame must not be empty");
  if (auto finished = reader.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

}  // namespace extperfc::ros_params
