#include "ros/params/explorer_params.hpp"

namespace extperfc::ros_params {

namespace {

void read_frontiers(ParamReader& reader, navigate::FrontierParams& frontiers) {
  reader.read("min_frontier_m", frontiers.min_length_m, {0.01, 100.0});
  reader.read("max_frontier_m", frontiers.max_length_m, {0.01, 1000.0});
  reader.read("gain_weight", frontiers.gain_weight, {0.0, 1000.0});
  reader.read("max_standoff_m", frontiers.max_standoff_m, {0.1, 20.0});
  reader.read("start_tolerance_m", frontiers.start_tolerance_m, {0.0, 10.0});
  reader.read("blacklist_radius_m", frontiers.blacklist_radius_m, {0.01, 100.0});
  reader.read("allow_unknown", frontiers.allow_unknown);
  reader.read("passage_slack_m", frontiers.passage_slack_m, {0.0, 1.0});
  if (frontiers.max_length_m < frontiers.min_length_m)
    reader.complain("max_frontier_m must not be less than min_frontier_m");
}

}  // namespace

Result<ExplorerParams> load_explorer_params(const ros::NodeHandle& private_handle) {
  ExplorerParams params;
  ParamReader reader(private_handle);
  reader.read_frame("robot_base_frame", params.base_frame);
  read_footprint(reader, private_handle, params.footprint);
  read_frontiers(reader, params.frontiers);
  reader.read("map_patience_s", params.map_patience_s, {0.1, 3600.0});
  reader.read("navigator_patience_s", params.navigator_patience_s, {0.1, 3600.0});
  reader.read("transform_timeout_s", params.transform_timeout_s, {0.0, 60.0});
  reader.read("goal_timeout_s", params.goal_timeout_s, {1.0, 1e5});
  if (auto finished = reader.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

}  // namespace extperfc::ros_params
