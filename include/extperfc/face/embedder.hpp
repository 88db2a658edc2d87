#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/detect/inference.hpp"
#include "extperfc/face/alignment.hpp"

namespace extperfc::face {

/// Numbers that describe a face; of length 1, so that a scalar product compares two.
using Feature = std::vector<float>;

/// Scalar product of two features of one embedder. Network: cosine of the angle, [-1, 1]. Local binary
/// patterns: Bhattacharyya coefficient, [0, 1]. 1 = the same. 0 for features of different sizes.
[[nodiscard]] float similarity(const Feature& a, const Feature& b);

/// Turns aligned faces into features. One thread at a time.
class FaceEmbedder {
 public:
  FaceEmbedder() = default;
  FaceEmbedder(const FaceEmbedder&) = delete;
  FaceEmbedder& operator=(const FaceEmbedder&) = delete;
  virtual ~FaceEmbedder() = default;

  /// Which features these are: those of equal identities, and no others, may be compared.
  [[nodiscard]] virtual std::string identity() const = 0;
  /// What really executes, for logs and diagnostics.
  [[nodiscard]] virtual std::string execution() const = 0;
  /// Numbers in a feature.
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// Similarity from which on two faces are taken for the same person's.
  [[nodiscard]] virtual float default_threshold() const = 0;
  /// By which a second person must be less similar, at least.
  [[nodiscard]] virtual float default_margin() const = 0;
  /// Errors: kFailed when the network fails or its output has no direction (zero, not finite).
  [[nodiscard]] virtual Result<Feature> embed(const AlignedFace& face) = 0;
};

/// Histograms of uniform local binary patterns, 8 neighbours at a radius of 2 pixels, over 7 x 7 cells
/// (Ahonen, Hadid and Pietikainen 2006, "Face Description with Local Binary Patterns"), compared by the
/// Bhattacharyya coefficient of each cell. Needs no weights and does not see monotonic changes of brightness.
/// Much weaker than a network: it compares textures, so it confuses people as soon as pose, distance or
/// expression change.
[[nodiscard]] std::unique_ptr<FaceEmbedder> make_lbp_embedder();

/// An ONNX network from 112 x 112 pixels to one vector. `path` is the file, fed with RGB from 0 to 255 as
/// OpenCV's SFace is, or a model folder of layout `vector`, whose model.yaml says how to feed it. Its default
/// threshold is 0.363, that of SFace (Zhong et al. 2021). Errors: those of detect::load_model_spec() and
/// detect::make_backend(); kInvalidArgument for a folder with another layout or input size.
[[nodiscard]] Result<std::unique_ptr<FaceEmbedder>> make_network_embedder(
    const std::filesystem::path& path, const detect::InferenceOptions& options);

}  // namespace extperfc::face
