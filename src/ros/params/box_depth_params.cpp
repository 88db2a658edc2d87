#include "ros/params/box_depth_params.hpp"

#include "ros/params/list_reader.hpp"

namespace extperfc::ros_params {

Result<BoxDepthNodeletParams> load_box_depth_params(const ros::NodeHandle& private_handle) {
  BoxDepthNodeletParams params;
  auto& estimate = params.estimate;
  std::string estimator = depth::to_string(estimate.estimator);

  ParamReader reader(private_handle);
  reader.read("enabled", params.enabled);
  reader.read("min_score", params.min_score, {0.0, 1.0});
  reader.read("class_filter", params.class_filter);
  reader.read("estimator", estimator);
  reader.read("window_px", estimate.window_px, {1, 1000});
  reader.read("central_fraction", estimate.central_fraction, {0.01, 1.0});
  reader.read("min_depth_m", estimate.min_depth_m, {0.0, 100.0});
  reader.read("max_depth_m", estimate.max_depth_m, {0.0, 100.0});
  reader.read("min_valid_px", estimate.min_valid_px, {1, 1000000});
  reader.read("noise_focal_px", estimate.noise.focal_px, {1.0, 10000.0});
  reader.read("noise_baseline_m", estimate.noise.baseline_m, {0.001, 1.0});
  reader.read("noise_subpixel_px", estimate.noise.subpixel_px, {0.001, 2.0});
  reader.read("target_frame", params.target_frame);
  reader.read("fit_objects", params.fit_objects);
  read_named_by_label(reader, private_handle, "shapes", params.shapes,
                      {{"cube", depth::FitShape::kCube},
                       {"sphere", depth::FitShape::kSphere},
                       {"cone", depth::FitShape::kCone}});
  reader.read("stamp_tolerance_s", params.stamp_tolerance_s, {0.0, 1.0});
  reader.read("transform_timeout_s", params.transform_timeout_s, {0.0, 5.0});
  reader.read("marker_lifetime_s", params.marker_lifetime_s, {0.0, 60.0});
  reader.read("timeout_s", params.timeout_s, {0.1, 3600.0});
  reader.read("depth_queue", params.depth_queue, {1, 300});
  reader.read("cloud_history", params.cloud_history, {1, 100});
  params.read = reader.params();

  if (auto known = depth::estimator_from_name(estimator)) {
    estimate.estimator = *known;
  } else {
    reader.complain(known.error().message);
  }
  if (params.fit_objects && params.target_frame.empty())
    reader.complain("fit_objects needs a target_frame whose z points up, e.g. base_footprint");
  if (params.fit_objects && params.shapes.empty())
    reader.complain("fit_objects needs shapes: which shape has each class, e.g. {box: cube}");
  if (auto fits = depth::validate(estimate); !fits) reader.complain(fits.error().message);
  if (auto finished = reader.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

}  // namespace extperfc::ros_params
