#include "test/benchmark/detect/core_chain.hpp"

#include <utility>

#include <Eigen/Geometry>
#include <vision_msgs/Detection3DArray.h>

#include "extperfc/depth/box_depth.hpp"
#include "extperfc/detect/decode.hpp"

#include "ros/convert/detections.hpp"
#include "ros/convert/image.hpp"

namespace extperfc::benchmark {

CoreChain::CoreChain(detect::ModelSpec spec, std::unique_ptr<detect::InferenceBackend> backend,
                     sensor_msgs::CameraInfo info)
    : spec_(std::move(spec)),
      backend_(std::move(backend)),
      preprocessor_(spec_.input),
      info_(std::move(info)) {}

Result<ChainCosts> CoreChain::run(const sensor_msgs::ImageConstPtr& color,
                                  const sensor_msgs::ImageConstPtr& depth) {
  ChainCosts costs;
  CostWatch watch;
  const auto placement = prepare(color);
  if (!placement) return tl::unexpected(placement.error());
  costs.prepare = watch.lap();
  const auto tensors = backend_->infer(0);
  if (!tensors) return tl::unexpected(tensors.error());
  costs.inference = watch.lap();
  const auto detections = decode(*tensors, *placement);
  costs.decode = watch.lap();
  if (auto located = locate(detections, depth); !located) return tl::unexpected(located.error());
  costs.depth = watch.lap();
  costs.boxes = detections.size();
  return costs;
}

Result<detect::Placement> CoreChain::prepare(const sensor_msgs::ImageConstPtr& color) {
  const auto image = ros_convert::share_image(color);
  if (!image) return tl::unexpected(image.error());
  return preprocessor_.run(image->view, backend_->input(0));
}

Detections CoreChain::decode(const std::vector<detect::TensorView>& tensors,
                             const detect::Placement& placement) const {
  auto detections = detect::suppress(detect::decode(spec_, tensors), spec_.thresholds);
  for (auto& detection : detections) detection.box = placement.to_image(detection.box);
  return detections;
}

Result<void> CoreChain::locate(const Detections& detections, const sensor_msgs::ImageConstPtr& depth) const {
  const auto message = ros_convert::to_message(detections, depth->header);
  const auto image = ros_convert::share_image(depth);
  if (!image) return tl::unexpected(image.error());
  const auto camera = ros_convert::to_camera_model(info_);
  if (!camera) return tl::unexpected(camera.error());
  vision_msgs::Detection3DArray objects;
  objects.header = message.header;
  for (const auto& detection : ros_convert::from_message(message)) {
    const auto estimate = depth::estimate_depth(image->view, detection.box, {});
    if (!estimate) continue;
    objects.detections.push_back(ros_convert::to_message(detection,
                                                         depth::locate(*camera, detection.box, *estimate),
                                                         Eigen::Isometry3d::Identity(), objects.header));
  }
  return {};
}

Result<Cost> CoreChain::infer() {
  CostWatch watch;
  if (const auto tensors = backend_->infer(0); !tensors) return tl::unexpected(tensors.error());
  return watch.lap();
}

}  // namespace extperfc::benchmark
