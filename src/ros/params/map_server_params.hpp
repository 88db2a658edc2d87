#pragma once

#include <string>

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"

namespace extperfc::ros_params {

struct MapServerParams {
  std::string map_file;         ///< YAML of the one map
  std::string floors;           ///< YAML of named floors; one of both is given
  std::string floor;            ///< of `floors`, to begin with; empty: the first
  std::string frame_id{"map"};  ///< of the map
};

/// Reads `private_handle`; every problem is reported at once. `map_file`: given on the command line, used
/// instead of the parameter; empty: none.
[[nodiscard]] Result<MapServerParams> load_map_server_params(const ros::NodeHandle& private_handle,
                                                             const std::string& map_file = "");

}  // namespace extperfc::ros_params
