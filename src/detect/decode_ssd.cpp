#include <algorithm>
#include <cmath>

#include "detect/decode_layouts.hpp"

namespace extperfc::detect {

namespace {

/// Softmax of `logits` into `scores`, shifted by the largest logit against overflow.
void softmax(const float* logits, std::vector<float>& scores) {
  const float largest = *std::max_element(logits, logits + scores.size());
  float sum = 0.0F;
  for (std::size_t i = 0; i < scores.size(); ++i) sum += scores[i] = std::exp(logits[i] - largest);
  for (float& score : scores) score /= sum;
}

/// Class scores of one candidate after another.
class ScoreRows {
 public:
  ScoreRows(const ModelSpec& spec, const TensorView& scores)
      : data_(scores.data),
        columns_(static_cast<std::size_t>(ssd_columns(spec))),
        background_(spec.output.background_class),
        softmaxed_(spec.output.apply_softmax ? columns_ : 0U),
        margin_(min_logit(spec.thresholds.score)) {}

  /// Scores of candidate `i`; empty when none of them can reach the threshold.
  const float* row(int i) {
    const float* row = data_ + static_cast<std::size_t>(i) * columns_;
    if (softmaxed_.empty()) return row;
    if (background_ >= 0 && is_background(row)) return nullptr;
    softmax(row, softmaxed_);
    return softmaxed_.data();
  }

 private:
  /// A class at softmax score p is at least min_logit(p) above every other one. Most candidates are
  /// background, and this spares them the exponentials.
  bool is_background(const float* row) const {
    const float bar = row[background_] + margin_;
    return std::none_of(row, row + columns_, [bar](float value) { return value >= bar; });
  }

  const float* data_;
  std::size_t columns_;
  int background_;
  std::vector<float> softmaxed_;
  float margin_;
};

template <typename BoxOf>
Detections decode_rows(const ModelSpec& spec, const TensorView& scores, const BoxOf& box_of) {
  const int background = spec.output.background_class;
  ScoreRows rows(spec, scores);
  Detections found;
  for (int i = 0; i < axis_from_end(scores, 1); ++i) {
    const float* row = rows.row(i);
    if (row == nullptr) continue;
    for (int column = 0; column < ssd_columns(spec); ++column)
      if (column != background && row[column] >= spec.thresholds.score)
        add_candidate(found, column - (background >= 0 && column > background ? 1 : 0), row[column],
                      box_of(i));
  }
  return found;
}

}  // namespace

Detections decode_ssd(const ModelSpec& spec, const std::vector<TensorView>& outputs) {
  const auto width = static_cast<float>(spec.input.width);
  const auto height = static_cast<float>(spec.input.height);
  return decode_rows(spec, outputs[1], [&](int i) {
    const float* box = outputs[0].data + 4 * static_cast<std::size_t>(i);
    return Box2{box[0] * width, box[1] * height, box[2] * width, box[3] * height};
  });
}

Detections decode_ssd_priors(const ModelSpec& spec, const std::vector<TensorView>& outputs) {
  const auto width = static_cast<float>(spec.input.width);
  const auto height = static_cast<float>(spec.input.height);
  const auto [center_variance, size_variance] = spec.output.variances;
  return decode_rows(spec, outputs[1], [&, cv = center_variance, sv = size_variance](int i) {
    const float* offset = outputs[0].data + 4 * static_cast<std::size_t>(i);
    const Prior& prior = spec.output.priors[static_cast<std::size_t>(i)];
    return box_around(
        (prior.cx + offset[0] * cv * prior.w) * width, (prior.cy + offset[1] * cv * prior.h) * height,
        prior.w * std::exp(offset[2] * sv) * width, prior.h * std::exp(offset[3] * sv) * height);
  });
}

}  // namespace extperfc::detect
