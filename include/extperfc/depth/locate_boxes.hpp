#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "extperfc/depth/box_depth.hpp"
#include "extperfc/depth/object_fit.hpp"

namespace extperfc::depth {

/// Which objects stand on a level support and have a known shape.
struct ShapesToFit {
  std::vector<std::optional<FitShape>> of_class;  ///< by class index; classes beyond the end have none
  Eigen::Vector3d up{Eigen::Vector3d::UnitZ()};   ///< see fit_object()
};

struct LocatedBox {
  Detection detection;
  Object3 object;
  std::optional<ObjectFit> fit;  ///< of a class with a shape that the depth shows
};

struct LocatedBoxes {
  std::vector<LocatedBox> boxes;  ///< in the order of the detections, without those that have no depth
  int without_depth{0};
  int not_fitted{0};  ///< of a class with a shape, but the depth shows another one
};

/// Position of every detected box, from depth aligned to its image. Preconditions: those of estimate_depth()
/// and locate().
[[nodiscard]] LocatedBoxes locate_boxes(const Detections& detections, const ImageView& depth,
                                        const CameraModel& camera, const BoxDepthParams& params,
                                        const ShapesToFit& shapes = {});

}  // namespace extperfc::depth
