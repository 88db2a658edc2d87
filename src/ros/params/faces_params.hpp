#pragma once

#include <filesystem>
#include <string>

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/depth/box_depth.hpp"
#include "extperfc/detect/inference.hpp"

namespace extperfc::ros_params {

struct FacesParams {
  std::filesystem::path model;    ///< folder of a YuNet
  std::string embedder{"lbp"};    ///< lbp, or an ONNX file or model folder
  std::filesystem::path gallery;  ///< YAML file of names; empty: names are lost at the end
  detect::InferenceOptions inference;
  double score_threshold{-1.0};  ///< [0, 1]; negative: the model's own
  double nms_iou{-1.0};          ///< [0, 1]; negative: the model's own
  int max_faces{0};              ///< per image; 0: the model's own
  double max_rate_hz{0.0};       ///< of images that are looked at, by their stamps; 0: as many as can be
  double min_face_px{40.0};      ///< smaller faces stay unknown
  double threshold{-1.0};        ///< smallest similarity of a known face; negative: the embedder's own
  double margin{-1.0};           ///< to the second name; negative: the embedder's own
  int max_features{20};          ///< of one name
  int enroll_samples{5};
  double enroll_interval_s{0.3};  ///< between two samples, by the stamps of their images
  bool use_depth{true};
  depth::BoxDepthParams estimate;
  std::string target_frame;         ///< of positions; empty: the camera's optical frame
  double stamp_tolerance_s{0.02};   ///< largest difference between an image's and its depth image's stamp
  double depth_wait_s{0.05};        ///< longest wait for the depth image of an image
  int depth_queue{30};              ///< depth images remembered while the networks work
  double transform_timeout_s{0.1};  ///< longest wait for a transform at the image's stamp
  double marker_lifetime_s{1.0};
  double timeout_s{5.0};  ///< silence on an input after which diagnostics warn
};

/// Reads `private_handle`; every problem is reported at once.
[[nodiscard]] Result<FacesParams> load_faces_params(const ros::NodeHandle& private_handle);

}  // namespace extperfc::ros_params
