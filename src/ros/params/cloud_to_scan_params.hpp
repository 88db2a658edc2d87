#pragma once

#include <string>

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/scan/cloud_to_scan.hpp"

namespace extperfc::ros_params {

struct CloudToScanNodeletParams {
  scan::ScanParams scan;
  std::string target_frame;         ///< empty = the cloud's
  double transform_tolerance{0.1};  ///< how long to wait for a transform at the cloud's stamp [s]
  double scan_time{0.1};            ///< from scan to scan [s]
  double timeout_s{5.0};            ///< silence on the input after which diagnostics warn [s]
};

/// Reads `private_handle`; every problem is reported at once.
[[nodiscard]] Result<CloudToScanNodeletParams> load_cloud_to_scan_params(
    const ros::NodeHandle& private_handle);

}  // namespace extperfc::ros_params
