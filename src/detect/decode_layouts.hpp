#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "extperfc/detect/inference.hpp"
#include "extperfc/detect/model_spec.hpp"
#include "extperfc/world/detection.hpp"

namespace extperfc::detect {

// One decoder per layout; the shapes have passed check_outputs(). Boxes in input pixels.
[[nodiscard]] Detections decode_ssd(const ModelSpec& spec, const std::vector<TensorView>& outputs);
[[nodiscard]] Detections decode_ssd_priors(const ModelSpec& spec, const std::vector<TensorView>& outputs);
[[nodiscard]] Detections decode_yolo_v7(const ModelSpec& spec, const TensorView& output);
[[nodiscard]] Detections decode_yolo_v8(const ModelSpec& spec, const TensorView& output);
[[nodiscard]] Detections decode_yolo_anchors(const ModelSpec& spec, const std::vector<TensorView>& outputs);
[[nodiscard]] Detections decode_yolo_grid(const ModelSpec& spec, const TensorView& output);
[[nodiscard]] Detections decode_yunet_boxes(const ModelSpec& spec, const std::vector<TensorView>& outputs);

/// Shapes of YuNet's tensors, in the order of OutputSpec::names.
[[nodiscard]] std::vector<std::vector<int>> yunet_shapes(const InputSpec& input);

/// Number of score columns of an SSD: the classes and, where there is one, the background.
[[nodiscard]] inline int ssd_columns(const ModelSpec& spec) {
  return static_cast<int>(spec.classes.size()) + (spec.output.background_class >= 0 ? 1 : 0);
}

/// Size of axis `i` counted from the last one (0), so that a leading batch dimension does not matter.
[[nodiscard]] inline int axis_from_end(const TensorView& tensor, std::size_t i) {
  return tensor.shape[tensor.shape.size() - 1 - i];
}

[[nodiscard]] inline float sigmoid(float x) {
  return 1.0F / (1.0F + std::exp(-x));
}

/// A lower bound, nearly exact, of the logits whose sigmoid reaches `p`: sigmoid() itself rounds to 1 from
/// about 17 on.
[[nodiscard]] inline float min_logit(float p) {
  const float below_one = std::min(p, 0.999999F);
  return std::log(below_one / (1.0F - below_one)) - 1e-4F;
}

[[nodiscard]] inline Box2 box_around(float cx, float cy, float w, float h) {
  return {cx - 0.5F * w, cy - 0.5F * h, cx + 0.5F * w, cy + 0.5F * h};
}

/// Adds a candidate unless a value is not finite or the box is empty.
inline void add_candidate(Detections& found, int class_index, float score, const Box2& box) {
  const float sum = score + box.x_min + box.y_min + box.x_max + box.y_max;
  if (std::isfinite(sum) && box.width() > 0.0F && box.height() > 0.0F)
    found.push_back({class_index, score, box});
}

struct BestClass {
  int index{0};
  float value{-std::numeric_limits<float>::infinity()};
};

/// Largest of `count` values that lie `stride` apart, the first of equals; NaN never wins.
[[nodiscard]] inline BestClass best_class(const float* values, int count, std::size_t stride) {
  BestClass best;
  for (int i = 0; i < count; ++i)
    if (values[static_cast<std::size_t>(i) * stride] > best.value)
      best = {i, values[static_cast<std::size_t>(i) * stride]};
  return best;
}

}  // namespace extperfc::detect
