#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/face/embedder.hpp"
#include "extperfc/face/face_detector.hpp"

namespace extperfc::face {

struct DescribedFace {
  DetectedFace face;
  std::optional<Feature> feature;  ///< empty: too small, or landmarks that coincide
};

/// Detector and embedder in a row. One thread at a time.
class Recognizer {
 public:
  /// Faces whose box is narrower or lower than `min_face_px` [px] get no feature.
  Recognizer(FaceDetector detector, std::unique_ptr<FaceEmbedder> embedder, float min_face_px);

  /// The faces of an image, best first. Errors: those of the detector, the alignment and the embedder.
  [[nodiscard]] Result<std::vector<DescribedFace>> describe(const ImageView& image);

  [[nodiscard]] const FaceDetector& detector() const { return detector_; }
  [[nodiscard]] const FaceEmbedder& embedder() const { return *embedder_; }

 private:
  FaceDetector detector_;
  std::unique_ptr<FaceEmbedder> embedder_;
  float min_face_px_;
};

}  // namespace extperfc::face
