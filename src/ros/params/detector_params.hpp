#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/detect/inference.hpp"

#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

struct DetectorParams {
  std::filesystem::path model;  ///< model folder
  detect::InferenceOptions inference;
  bool enabled{true};            ///< detect continuously while there are subscribers
  double score_threshold{-1.0};  ///< [0, 1]; negative = the model's own
  double nms_iou{-1.0};          ///< [0, 1]; negative = the model's own
  int max_detections{0};         ///< 0 = the model's own
  std::string class_filter;      ///< names or indices between commas; empty = all classes
  std::string image_transport{"raw"};
  double timeout_s{5.0};        ///< silence on the image topic after which diagnostics warn [s]
  std::vector<ReadParam> read;  ///< all of them, with their ranges
};

/// Reads `private_handle`; every problem is reported at once.
[[nodiscard]] Result<DetectorParams> load_detector_params(const ros::NodeHandle& private_handle);

/// Class names go to `<private>/classes`, where vision_msgs/VisionInfo::database_location points.
void store_class_names(const ros::NodeHandle& private_handle, const std::vector<std::string>& names);

/// The names stored at `location`, an absolute parameter name; empty when there are none or it is no
/// parameter name.
[[nodiscard]] std::vector<std::string> load_class_names(const std::string& location);

}  // namespace extperfc::ros_params
