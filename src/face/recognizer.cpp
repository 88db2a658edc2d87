#include "extperfc/face/recognizer.hpp"

#include <algorithm>
#include <utility>

namespace extperfc::face {

Recognizer::Recognizer(FaceDetector detector, std::unique_ptr<FaceEmbedder> embedder, float min_face_px)
    : detector_(std::move(detector)), embedder_(std::move(embedder)), min_face_px_(min_face_px) {}

Result<std::vector<DescribedFace>> Recognizer::describe(const ImageView& image) {
  auto faces = detector_.detect(image);
  if (!faces) return tl::unexpected(faces.error());
  std::vector<DescribedFace> described;
  std::vector<std::size_t> large;
  std::vector<Landmarks> landmarks;
  for (const auto& face : *faces) {
    described.push_back({face, {}});
    if (std::min(face.box.width(), face.box.height()) < min_face_px_) continue;
    large.push_back(described.size() - 1);
    landmarks.push_back(face.landmarks);
  }
  if (large.empty()) return described;
  const auto aligned = align(image, landmarks);
  if (!aligned) return tl::unexpected(aligned.error());
  for (std::size_t i = 0; i < large.size(); ++i) {
    if (!(*aligned)[i]) continue;
    auto feature = embedder_->embed(*(*aligned)[i]);
    if (!feature) return tl::unexpected(feature.error());
    described[large[i]].feature = std::move(*feature);
  }
  return described;
}

}  // namespace extperfc::face
