#pragma once

#include <string>

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/track/tracker.hpp"

namespace extperfc::ros_params {

struct TrackerNodeletParams {
  track::TrackerParams tracker;
  std::string fixed_frame;          ///< of the tracks, e.g. odom; empty = frame of the detections
  double transform_timeout_s{0.1};  ///< how long to wait for a transform at the stamp of the detections [s]
  bool publish_tentative{false};    ///< objects that are not confirmed, too
  double timeout_s{5.0};            ///< silence on the detections after which diagnostics warn [s]
};

/// Reads `private_handle`; every problem is reported at once.
[[nodiscard]] Result<TrackerNodeletParams> load_tracker_params(const ros::NodeHandle& private_handle);

}  // namespace extperfc::ros_params
