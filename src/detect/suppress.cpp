#include <algorithm>
#include <map>

#include <opencv2/dnn.hpp>

#include "extperfc/detect/decode.hpp"

namespace extperfc::detect {

namespace {

// Suppression takes quadratic time: a threshold near 0 must not stall the robot.
constexpr int kMaxCandidatesPerClass = 1000;

struct ClassCandidates {
  std::vector<cv::Rect2d> boxes;
  std::vector<float> scores;
  std::vector<std::size_t> indices;  ///< into the list that suppress() was given
};

}  // namespace

Detections suppress(const Detections& candidates, const Thresholds& thresholds) {
  std::map<int, ClassCandidates> classes;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const auto& [class_index, score, box] = candidates[i];
    if (!(score >= thresholds.score)) continue;
    ClassCandidates& group = classes[class_index];
    group.boxes.emplace_back(box.x_min, box.y_min, box.width(), box.height());
    group.scores.push_back(score);
    group.indices.push_back(i);
  }

  Detections kept;
  std::vector<int> survivors;
  for (const auto& [class_index, group] : classes) {
    cv::dnn::NMSBoxes(group.boxes, group.scores, 0.0F, thresholds.nms_iou, survivors, 1.0F,
                      kMaxCandidatesPerClass);
    for (const int i : survivors) kept.push_back(candidates[group.indices[static_cast<std::size_t>(i)]]);
  }
  std::stable_sort(kept.begin(), kept.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
  if (kept.size() > static_cast<std::size_t>(thresholds.max_detections))
    kept.resize(static_cast<std::size_t>(thresholds.max_detections));
  return kept;
}

}  // namespace extperfc::detect
