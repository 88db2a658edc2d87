#include "ros/params/faces_params.hpp"

#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

Result<FacesParams> load_faces_params(const ros::NodeHandle& private_handle) {
  FacesParams params;
  std::string model;
  std::string gallery;
  std::string cache_dir;
  ParamReader reader(private_handle);
  reader.require("model", model, "name the folder of a YuNet, see docs/faces.md");
  reader.read("embedder", params.embedder);
  reader.read("gallery", gallery);
  reader.read("backend", params.inference.backend);
  reader.read("device", params.inference.device);
  reader.read("threads", params.inference.threads, {0, 256});
  reader.read("cache_dir", cache_dir);
  reader.read("score_threshold", params.score_threshold, {-1.0, 1.0});
  reader.read("nms_iou", params.nms_iou, {-1.0, 1.0});
  reader.read("max_faces", params.max_faces, {0, 1000});
  reader.read("max_rate_hz", params.max_rate_hz, {0.0, 1000.0});
  reader.read("min_face_px", params.min_face_px, {0.0, 10000.0});
  reader.read("threshold", params.threshold, {-1.0, 1.0});
  reader.read("margin", params.margin, {-1.0, 2.0});
  reader.read("max_features", params.max_features, {1, 1000});
  reader.read("enroll_samples", params.enroll_samples, {1, 100});
  reader.read("enroll_interval_s", params.enroll_interval_s, {0.0, 60.0});
  reader.read("use_depth", params.use_depth);
  reader.read("target_frame", params.target_frame);
  reader.read("min_depth_m", params.estimate.min_depth_m, {0.0, 100.0});
  reader.read("max_depth_m", params.estimate.max_depth_m, {0.0, 100.0});
  reader.read("stamp_tolerance_s", params.stamp_tolerance_s, {0.0, 1.0});
  reader.read("depth_wait_s", params.depth_wait_s, {0.0, 1.0});
  reader.read("depth_queue", params.depth_queue, {1, 300});
  reader.read("transform_timeout_s", params.transform_timeout_s, {0.0, 5.0});
  reader.read("marker_lifetime_s", params.marker_lifetime_s, {0.0, 60.0});
  reader.read("timeout_s", params.timeout_s, {0.1, 3600.0});
  params.model = model;
  params.gallery = gallery;
  params.inference.cache_dir = cache_dir;
  if (auto fits = depth::validate(params.estimate); !fits) reader.complain(fits.error().message);
  if (auto finished = reader.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

}  // namespace extperfc::ros_params
