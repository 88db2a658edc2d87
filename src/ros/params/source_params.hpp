#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/world/camera_model.hpp"

namespace extperfc::ros_params {

/// Parameters of the nodelets that play recordings.
struct SourceParams {
  std::filesystem::path path;      ///< folder of images, or rawlog file
  double rate_hz{10.0};            ///< frames per second; 0 = as recorded
  bool loop{true};                 ///< start again at the end
  bool wait_for_subscriber{true};  ///< wait for the first subscriber, so that no message is lost
  bool recorded_stamps{false};     ///< stamps of the recording instead of the time of publishing
  double depth_scale{1000.0};      ///< units per metre of depth files
  std::string frame_id{"camera_color_optical_frame"};
  std::string world_frame{"map"};  ///< frame of recorded camera poses
  std::optional<CameraModel>
      camera;  ///< from `camera_info` or `fx fy cx cy width height`; overrides the recording's
};

[[nodiscard]] Result<SourceParams> load_source_params(const ros::NodeHandle& private_handle);

}  // namespace extperfc::ros_params
