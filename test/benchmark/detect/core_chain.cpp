#include "detect/core_chain.hpp"

#include <Eigen/Geometry>
#include <vision_msgs/Detection3DArray.h>

#include "extperfc/base/stopwatch.hpp"

#include "ros/convert/detections.hpp"
#include "ros/convert/image.hpp"

namespace extperfc::benchmark {

Result<ChainTimes> CoreChain::run(const sensor_msgs::ImageConstPtr& color,
                                  const sensor_msgs::ImageConstPtr& depth) {
  const double cpu_start_s = process_cpu_seconds();
  const Stopwatch whole;
  const auto image = convert::share_image(color);
  if (!image) return tl::unexpected(image.error());
  const double wrap_ms = whole.milliseconds();
  const auto output = detector_.detect(image->view);
  if (!output) return tl::unexpected(output.error());
  const Stopwatch depth_watch;
  if (auto located = locate(output->detections, depth); !located) return tl::unexpected(located.error());
  const auto& times = output->times;
  return ChainTimes{
      wrap_ms + times.preprocess_ms, times.inference_ms,   times.decode_ms,
      depth_watch.milliseconds(),    whole.milliseconds(), 1e3 * (process_cpu_seconds() - cpu_start_s),
      output->detections.size()};
}

Result<void> CoreChain::locate(const Detections& detections, const sensor_msgs::ImageConstPtr& depth) const {
  const auto message = convert::to_message(detections, depth->header);
  const auto image = convert::share_image(depth);
  if (!image) return tl::unexpected(image.error());
  const auto camera = convert::to_camera_model(info_);
  if (!camera) return tl::unexpected(camera.error());
  vision_msgs::Detection3DArray objects;
  objects.header = message.header;
  for (const auto& detection : convert::from_message(message)) {
    const auto estimate = depth::estimate_depth(image->view, detection.box, {});
    if (!estimate) continue;
    objects.detections.push_back(convert::to_message(detection,
                                                     depth::locate(*camera, detection.box, *estimate),
                                                     Eigen::Isometry3d::Identity(), objects.header));
  }
  return {};
}

Result<InferenceTime> CoreChain::infer() {
  const double cpu_start_s = process_cpu_seconds();
  const Stopwatch watch;
  if (const auto tensors = detector_.backend().infer(0); !tensors) return tl::unexpected(tensors.error());
  return InferenceTime{watch.milliseconds(), 1e3 * (process_cpu_seconds() - cpu_start_s)};
}

}  // namespace extperfc::benchmark
