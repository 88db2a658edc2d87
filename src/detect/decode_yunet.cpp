#include <algorithm>
#include <cmath>

#include "extperfc/detect/yunet.hpp"

#include "detect/decode_layouts.hpp"
#include "detect/yunet_levels.hpp"

namespace extperfc::detect {

namespace {

/// The tensors of one stride.
struct YunetLevel {
  const float* cls;
  const float* obj;
  const float* bbox;
  const float* kps;
  int columns;  ///< cells
  int rows;     ///< cells
  float stride;
};

YunetLevel level_of(const ModelSpec& spec, const std::vector<TensorView>& outputs, std::size_t i) {
  const int stride = kYunetStrides[i];
  constexpr std::size_t kLevels = kYunetStrides.size();
  return {outputs[i].data,
          outputs[i + kLevels].data,
          outputs[i + 2 * kLevels].data,
          outputs[i + 3 * kLevels].data,
          spec.input.width / stride,
          spec.input.height / stride,
          static_cast<float>(stride)};
}

/// NaN becomes 0.
float limited(float probability) {
  return probability > 0.0F ? std::min(probability, 1.0F) : 0.0F;
}

YunetCandidate candidate_at(const YunetLevel& level, int cell, float score) {
  const int column = cell % level.columns;
  const int row = cell / level.columns;
  const Eigen::Vector2f corner(static_cast<float>(column), static_cast<float>(row));
  const auto at = static_cast<std::size_t>(cell);
  const float* bbox = level.bbox + 4 * at;
  const Eigen::Vector2f center = (corner + Eigen::Vector2f(bbox[0], bbox[1])) * level.stride;
  YunetCandidate candidate;
  candidate.detection = {
      0, score,
      box_around(center.x(), center.y(), std::exp(bbox[2]) * level.stride, std::exp(bbox[3]) * level.stride)};
  const float* kps = level.kps + 10 * at;
  for (auto& landmark : candidate.landmarks) {
    landmark = (corner + Eigen::Vector2f(kps[0], kps[1])) * level.stride;
    kps += 2;
  }
  return candidate;
}

bool is_usable(const YunetCandidate& candidate) {
  Detections accepted;
  add_candidate(accepted, 0, candidate.detection.score, candidate.detection.box);
  return !accepted.empty() && std::all_of(candidate.landmarks.begin(), candidate.landmarks.end(),
                                          [](const Eigen::Vector2f& point) { return point.allFinite(); });
}

}  // namespace

std::vector<std::vector<int>> yunet_shapes(const InputSpec& input) {
  std::vector<std::vector<int>> shapes;
  for (const int columns : kYunetColumns)
    for (const int stride : kYunetStrides)
      shapes.push_back({(input.width / stride) * (input.height / stride), columns});
  return shapes;
}

std::vector<YunetCandidate> decode_yunet(const ModelSpec& spec, const std::vector<TensorView>& outputs) {
  std::vector<YunetCandidate> found;
  for (std::size_t i = 0; i < kYunetStrides.size(); ++i) {
    const YunetLevel level = level_of(spec, outputs, i);
    for (int cell = 0; cell < level.columns * level.rows; ++cell) {
      const float score = std::sqrt(limited(level.cls[cell]) * limited(level.obj[cell]));
      if (!(score >= spec.thresholds.score)) continue;
      const auto candidate = candidate_at(level, cell, score);
      if (is_usable(candidate)) found.push_back(candidate);
    }
  }
  return found;
}

Detections decode_yunet_boxes(const ModelSpec& spec, const std::vector<TensorView>& outputs) {
  Detections boxes;
  for (const auto& candidate : decode_yunet(spec, outputs)) boxes.push_back(candidate.detection);
  return boxes;
}

}  // namespace extperfc::detect
