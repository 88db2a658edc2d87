#pragma once

#include <string>
#include <vector>

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/navigate/velocity.hpp"
#include "extperfc/navigate/velocity_mux.hpp"

namespace extperfc::ros_params {

struct MuxSourceParams {
  std::string topic;
  navigate::VelocitySource source;
};

struct CmdVelMuxParams {
  std::vector<MuxSourceParams> sources;
  navigate::VelocityLimits limits;
  std::string stop_topic{"e_stop"};
  double rate_hz{20.0};
};

/// Reads `private_handle`; every problem is reported at once.
[[nodiscard]] Result<CmdVelMuxParams> load_cmd_vel_mux_params(const ros::NodeHandle& private_handle);

}  // namespace extperfc::ros_params
