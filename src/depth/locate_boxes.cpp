#include "extperfc/depth/locate_boxes.hpp"

#include <algorithm>
#include <utility>

namespace extperfc::depth {

namespace {

ObjectFitParams fit_params(const BoxDepthParams& box) {
  ObjectFitParams params;
  params.min_depth_m = std::max(box.min_depth_m, 1e-3);
  params.max_depth_m = box.max_depth_m;
  params.noise = box.noise;
  return params;
}

}  // namespace

LocatedBoxes locate_boxes(const Detections& detections, const ImageView& depth, const CameraModel& camera,
                          const BoxDepthParams& params, const ShapesToFit& shapes) {
  LocatedBoxes located;
  for (const auto& detection : detections) {
    const auto estimate = estimate_depth(depth, detection.box, params);
    if (!estimate) {
      ++located.without_depth;
      continue;
    }
    LocatedBox one{detection, locate(camera, detection.box, *estimate), std::nullopt};
    const auto index = static_cast<std::size_t>(detection.class_index);  // a negative one is beyond the end
    if (index < shapes.of_class.size() && shapes.of_class[index]) {
      const auto fit =
          fit_object(depth, camera, detection.box, *shapes.of_class[index], shapes.up, fit_params(params));
      if (fit)
        one.fit = *fit;
      else
        ++located.not_fitted;
    }
    located.boxes.push_back(std::move(one));
  }
  return located;
}

}  // namespace extperfc::depth
