#include "ros/params/detector_params.hpp"

#include <ros/names.h>
#include <ros/package.h>
#include <ros/param.h>

#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

namespace {

/// Takes the value of a name lookup, or notes its error.
template <typename T>
void accept_or_complain(ParamReader& reader, Result<T> looked_up, T& value) {
  if (looked_up) {
    value = *looked_up;
  } else {
    reader.complain(looked_up.error().message);
  }
}

}  // namespace

Result<DetectorParams> load_detector_params(const ros::NodeHandle& private_handle) {
  DetectorParams params;
  std::string model = ros::package::getPath("extperfc") + "/models/shapes";
  std::string precision = detect::to_string(params.inference.precision);
  std::string mode = detect::to_string(params.inference.mode);
  std::string cache_dir;

  ParamReader reader(private_handle);
  reader.accept("classes");
  reader.read("model", model);
  reader.read("backend", params.inference.backend);
  reader.read("device", params.inference.device);
  reader.read("threads", params.inference.threads, {0, 256});
  reader.read("precision", precision);
  reader.read("mode", mode);
  reader.read("cache_dir", cache_dir);
  reader.read("enabled", params.enabled);
  reader.read("score_threshold", params.score_threshold, {-1.0, 1.0});
  reader.read("nms_iou", params.nms_iou, {-1.0, 1.0});
  reader.read("max_detections", params.max_detections, {0, 10000});
  reader.read("class_filter", params.class_filter);
  reader.read("image_transport", params.image_transport);
  reader.read("timeout_s", params.timeout_s, {0.1, 3600.0});
  accept_or_complain(reader, detect::precision_from_name(precision), params.inference.precision);
  accept_or_complain(reader, detect::mode_from_name(mode), params.inference.mode);
  params.model = model;
  params.inference.cache_dir = cache_dir;
  params.read = reader.params();

  if (auto finished = reader.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

void store_class_names(const ros::NodeHandle& private_handle, const std::vector<std::string>& names) {
  private_handle.setParam("classes", names);
}

std::vector<std::string> load_class_names(const std::string& location) {
  std::vector<std::string> names;
  std::string why_not;
  // VisionInfo leaves the form of the location open: a file or a web address is no parameter name and would
  // throw.
  if (location.empty() || !ros::names::validate(location, why_not)) return names;
  ros::param::get(location, names);
  return names;
}

}  // namespace extperfc::ros_params
