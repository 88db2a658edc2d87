#include <algorithm>
#include <cmath>

#include "detect/decode_layouts.hpp"

namespace extperfc::detect {

namespace {

constexpr int kScanBlock = 64;  // values tested by one vectorised comparison loop

int class_count(const ModelSpec& spec) {
  return static_cast<int>(spec.classes.size());
}

/// Calls `hit(i)` for every value at or above the threshold, which few are. NaN is below.
template <typename Hit>
void scan(const float* values, int count, float threshold, const Hit& hit) {
  for (int begin = 0; begin < count; begin += kScanBlock) {
    const int end = std::min(begin + kScanBlock, count);
    int any = 0;
    for (int i = begin; i < end; ++i) any |= static_cast<int>(values[i] >= threshold);
    for (int i = begin; any != 0 && i < end; ++i)
      if (values[i] >= threshold) hit(i);
  }
}

/// One anchor of one level of a raw head: planes of x, y, w, h, objectness and the classes.
void decode_anchor(const ModelSpec& spec, const float* planes, int columns, int rows, int stride_px,
                   const std::array<float, 2>& anchor_px, Detections& found) {
  const auto area = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  const auto stride = static_cast<float>(stride_px);
  // The score is at most the objectness.
  scan(planes + 4 * area, columns * rows, min_logit(spec.thresholds.score), [&](int cell) {
    const float* at = planes + cell;
    const BestClass best = best_class(at + 5 * area, class_count(spec), area);
    const float score = sigmoid(at[4 * area]) * sigmoid(best.value);
    if (!(score >= spec.thresholds.score)) return;
    const auto column = cell % columns;
    const auto row = cell / columns;
    const float cx = (2.0F * sigmoid(at[0]) - 0.5F + static_cast<float>(column)) * stride;
    const float cy = (2.0F * sigmoid(at[area]) - 0.5F + static_cast<float>(row)) * stride;
    const float w = 2.0F * sigmoid(at[2 * area]);
    const float h = 2.0F * sigmoid(at[3 * area]);
    add_candidate(found, best.index, score, box_around(cx, cy, w * w * anchor_px[0], h * h * anchor_px[1]));
  });
}

}  // namespace

Detections decode_yolo_v7(const ModelSpec& spec, const TensorView& output) {
  const auto columns = static_cast<std::size_t>(axis_from_end(output, 0));
  const float* row = output.data;
  Detections found;
  for (int i = 0; i < axis_from_end(output, 1); ++i, row += columns) {
    if (!(row[4] >= spec.thresholds.score)) continue;  // the score is at most the objectness
    const BestClass best = best_class(row + 5, class_count(spec), 1);
    const float score = row[4] * best.value;
    if (score >= spec.thresholds.score)
      add_candidate(found, best.index, score, box_around(row[0], row[1], row[2], row[3]));
  }
  return found;
}

Detections decode_yolo_v8(const ModelSpec& spec, const TensorView& output) {
  const int count = axis_from_end(output, 0);
  const auto row = static_cast<std::size_t>(count);
  const float* scores = output.data + 4 * row;
  Detections found;
  for (int c = 0; c < class_count(spec); ++c)
    scan(scores + static_cast<std::size_t>(c) * row, count, spec.thresholds.score, [&](int i) {
      const BestClass best = best_class(scores + i, class_count(spec), row);
      if (best.index != c) return;  // found in the row of its best class
      const float* at = output.data + i;
      add_candidate(found, c, best.value, box_around(at[0], at[row], at[2 * row], at[3 * row]));
    });
  return found;
}

Detections decode_yolo_anchors(const ModelSpec& spec, const std::vector<TensorView>& outputs) {
  Detections found;
  for (std::size_t level = 0; level < outputs.size(); ++level) {
    const auto& [stride, anchors] = spec.output.anchors[level];
    const int columns = axis_from_end(outputs[level], 0);
    const int rows = axis_from_end(outputs[level], 1);
    const std::size_t anchor_size = static_cast<std::size_t>(5 + class_count(spec)) *
                                    static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    for (std::size_t a = 0; a < anchors.size(); ++a)
      decode_anchor(spec, outputs[level].data + a * anchor_size, columns, rows, stride, anchors[a], found);
  }
  return found;
}

Detections decode_yolo_grid(const ModelSpec& spec, const TensorView& output) {
  const int columns = axis_from_end(output, 0);
  const int rows = axis_from_end(output, 1);
  const auto area = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  const float cell_w = static_cast<float>(spec.input.width) / static_cast<float>(columns);
  const float cell_h = static_cast<float>(spec.input.height) / static_cast<float>(rows);
  // Class scores are at most 1, so the objectness alone must reach the threshold.
  const float min_objectness = std::pow(spec.thresholds.score, 1.0F / 0.6F);
  Detections found;
  scan(output.data, columns * rows, min_objectness, [&](int cell) {
    const float* at = output.data + cell;
    const BestClass best = best_class(at + 5 * area, class_count(spec), area);
    const float score = std::pow(at[0], 0.6F) * std::pow(best.value, 0.4F);
    if (!(score >= spec.thresholds.score)) return;
    const auto column = cell % columns;
    const auto row = cell / columns;
    const float cx = (std::tanh(at[area]) + static_cast<float>(column)) * cell_w;
    const float cy = (std::tanh(at[2 * area]) + static_cast<float>(row)) * cell_h;
    const float w = sigmoid(at[3 * area]) * static_cast<float>(spec.input.width);
    const float h = sigmoid(at[4 * area]) * static_cast<float>(spec.input.height);
    add_candidate(found, best.index, score, box_around(cx, cy, w, h));
  });
  return found;
}

}  // namespace extperfc::detect
