#pragma once

#include <string>
#include <vector>

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/scan/cloud_to_scan.hpp"

namespace extperfc::ros_params {

/// Where the vertical comes from.
enum class LevelFrom {
  kNone,  ///< the target frame stands upright
  kTf,    ///< from fixed_frame, whose z axis points upwards
  kImu,   ///< from the orientation of an IMU
};
[[nodiscard]] const char* to_string(LevelFrom level);

struct CloudToScanNodeletParams {
  scan::ScanParams scan;
  std::vector<scan::SelfVolume> self_volumes;  ///< of the robot
  double self_padding{0.03};                   ///< added to every side of them [m]
  std::string target_frame;                    ///< empty = the cloud's
  std::string fixed_frame;  ///< clouds are deskewed by the motion in it; empty: they are not
  bool deskew{true};        ///< false: fixed_frame serves for the vertical only
  LevelFrom level{LevelFrom::kTf};
  double transform_tolerance{0.1};  ///< how long to wait for a transform at the cloud's stamp [s]
  double timeout_s{5.0};            ///< silence on the input after which diagnostics warn [s]
};

/// Reads `private_handle`; every problem is reported at once.
[[nodiscard]] Result<CloudToScanNodeletParams> load_cloud_to_scan_params(
    const ros::NodeHandle& private_handle);

}  // namespace extperfc::ros_params
