#pragma once

#include <map>
#include <string>

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/depth/box_depth.hpp"
#include "extperfc/depth/object_fit.hpp"

#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

struct BoxDepthNodeletParams {
  bool enabled{true};        ///< compute continuously while there are subscribers
  double min_score{0.0};     ///< boxes with a lower score are left out, [0, 1]
  std::string class_filter;  ///< names or indices between commas; empty = all classes
  depth::BoxDepthParams estimate;
  std::string target_frame;  ///< empty = the camera's optical frame
  bool fit_objects{false};   ///< fit `shapes` to standing objects; needs a target frame whose z is up
  std::map<std::string, depth::FitShape> shapes;  ///< by class; objects of other classes are not fitted
  double stamp_tolerance_s{
      0.02};  ///< largest difference between a detection's and its depth image's stamp [s]
  double transform_timeout_s{0.1};  ///< how long to wait for a transform at the image's stamp [s]
  double marker_lifetime_s{1.0};    ///< [s]
  double timeout_s{5.0};            ///< silence on an input after which diagnostics warn [s]
  int depth_queue{30};              ///< depth images remembered while the detector works
  int cloud_history{5};             ///< results that object_cloud knows, with their depth images
  std::vector<ReadParam> read;      ///< all of them, with their ranges
};

/// Reads `private_handle`; every problem is reported at once.
[[nodiscard]] Result<BoxDepthNodeletParams> load_box_depth_params(const ros::NodeHandle& private_handle);

}  // namespace extperfc::ros_params
