#pragma once

#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/detect/inference.hpp"
#include "extperfc/detect/model_spec.hpp"
#include "extperfc/world/detection.hpp"

namespace extperfc::detect {

/// Checks that the tensors have the shapes that the layout asks for; done once, when a model is loaded.
/// The error says which tensor, which shape it has and which was expected.
[[nodiscard]] Result<void> check_outputs(const ModelSpec& spec, const std::vector<TensorView>& outputs);

/// Candidates at or above the score threshold, boxes in input pixels, before suppression. The shapes must
/// have passed check_outputs(). Candidates with a value that is not finite are left out.
[[nodiscard]] Detections decode(const ModelSpec& spec, const std::vector<TensorView>& outputs);

/// Non-maximum suppression within each class (cv::dnn::NMSBoxes), best first, at most `max_detections`.
[[nodiscard]] Detections suppress(const Detections& candidates, const Thresholds& thresholds);

}  // namespace extperfc::detect
