#include "extperfc/face/face_detector.hpp"

#include <algorithm>
#include <utility>

#include "extperfc/detect/yunet.hpp"

namespace extperfc::face {

namespace {

constexpr std::size_t kMaxCandidates = 1000;  // suppression takes quadratic time

Eigen::Vector2f to_image(const detect::Placement& placement, const Eigen::Vector2f& point) {
  return {(point.x() - placement.offset_x) / placement.scale_x,
          (point.y() - placement.offset_y) / placement.scale_y};
}

DetectedFace placed(const detect::YunetCandidate& candidate, const detect::Placement& placement) {
  DetectedFace face{placement.to_image(candidate.detection.box), {}, candidate.detection.score};
  std::transform(candidate.landmarks.begin(), candidate.landmarks.end(), face.landmarks.begin(),
                 [&](const Eigen::Vector2f& point) { return to_image(placement, point); });
  return face;
}

Box2 clipped(const Box2& box, const ImageView& image) {
  return {std::max(box.x_min, 0.0F), std::max(box.y_min, 0.0F),
          std::min(box.x_max, static_cast<float>(image.width)),
          std::min(box.y_max, static_cast<float>(image.height))};
}

bool overlaps_any(const DetectedFace& face, const std::vector<DetectedFace>& others, float max_iou) {
  return std::any_of(others.begin(), others.end(),
                     [&](const DetectedFace& other) { return iou(face.box, other.box) > max_iou; });
}

}  // namespace

FaceDetector::FaceDetector(detect::ModelSpec spec, std::unique_ptr<detect::InferenceBackend> backend)
    : spec_(std::move(spec)), backend_(std::move(backend)), preprocessor_(spec_.input) {}

Result<FaceDetector> FaceDetector::create(detect::ModelSpec spec, const detect::InferenceOptions& options) {
  if (spec.output.layout != detect::OutputLayout::kYunet)
    return fail(ErrorCode::kInvalidArgument,
                "model " + spec.name + " has the layout " + detect::to_string(spec.output.layout) +
                    ", but faces need one of layout yunet: name the folder of a YuNet");
  auto backend = detect::make_backend(spec, options);
  if (!backend) return tl::unexpected(backend.error());
  return FaceDetector(std::move(spec), std::move(*backend));
}

Result<std::vector<DetectedFace>> FaceDetector::detect(const ImageView& image) {
  const auto placement = preprocessor_.run(image, backend_->input(0));
  if (!placement) return tl::unexpected(placement.error());
  const auto tensors = backend_->infer(0);
  if (!tensors) return tl::unexpected(tensors.error());
  std::vector<DetectedFace> faces;
  for (const auto& candidate : detect::decode_yunet(spec_, *tensors))
    faces.push_back(placed(candidate, *placement));
  faces = suppress(std::move(faces), spec_.thresholds);
  for (auto& face : faces) face.box = clipped(face.box, image);
  faces.erase(std::remove_if(faces.begin(), faces.end(),
                             [](const DetectedFace& face) { return !(face.box.area() > 0.0F); }),
              faces.end());
  return faces;
}

std::vector<DetectedFace> suppress(std::vector<DetectedFace> faces, const detect::Thresholds& thresholds) {
  std::stable_sort(faces.begin(), faces.end(),
                   [](const DetectedFace& a, const DetectedFace& b) { return a.score > b.score; });
  if (faces.size() > kMaxCandidates) faces.resize(kMaxCandidates);
  std::vector<DetectedFace> kept;
  for (const auto& face : faces) {
    if (kept.size() >= static_cast<std::size_t>(thresholds.max_detections)) break;
    if (!overlaps_any(face, kept, thresholds.nms_iou)) kept.push_back(face);
  }
  return kept;
}

}  // namespace extperfc::face
