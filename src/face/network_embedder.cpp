#include <cmath>
#include <numeric>
#include <utility>

#include "extperfc/base/sha256.hpp"
#include "extperfc/detect/preprocess.hpp"
#include "extperfc/face/embedder.hpp"

namespace extperfc::face {

namespace fs = std::filesystem;

namespace {

constexpr float kSfaceThreshold = 0.363F;
constexpr float kCosineMargin = 0.05F;

class NetworkEmbedder : public FaceEmbedder {
 public:
  NetworkEmbedder(const detect::ModelSpec& spec, std::unique_ptr<detect::InferenceBackend> backend,
                  std::size_t size)
      : name_(spec.name),
        sha256_(spec.sha256),
        backend_(std::move(backend)),
        preprocessor_(spec.input),
        size_(size) {}

  std::string identity() const override { return "network " + sha256_; }
  std::string execution() const override {
    return name_ + ", " + backend_->name() + " on " + backend_->execution();
  }
  std::size_t size() const override { return size_; }
  float default_threshold() const override { return kSfaceThreshold; }
  float default_margin() const override { return kCosineMargin; }

  Result<Feature> embed(const AlignedFace& face) override {
    const auto placement = preprocessor_.run(face.view(), backend_->input(0));
    if (!placement) return tl::unexpected(placement.error());
    const auto tensors = backend_->infer(0);
    if (!tensors) return tl::unexpected(tensors.error());
    Feature feature(tensors->front().data, tensors->front().data + tensors->front().size());
    const float norm = std::sqrt(similarity(feature, feature));
    if (!(norm > 0.0F) || !std::isfinite(norm))
      return fail(ErrorCode::kFailed, "network " + name_ + ": its output for a face is zero or not finite");
    for (float& value : feature) value /= norm;
    return feature;
  }

 private:
  std::string name_;
  std::string sha256_;
  std::unique_ptr<detect::InferenceBackend> backend_;
  detect::Preprocessor preprocessor_;
  std::size_t size_;
};

/// A file without description is fed as SFace is.
Result<detect::ModelSpec> spec_of_file(const fs::path& file) {
  const auto sum = sha256_of_file(file);
  if (!sum) return tl::unexpected(sum.error());
  detect::ModelSpec spec;
  spec.name = file.stem().string();
  spec.folder = file.parent_path();
  spec.file = fs::absolute(file);
  spec.sha256 = *sum;
  spec.input.width = spec.input.height = kAlignedSize;
  spec.output.layout = detect::OutputLayout::kVector;
  return spec;
}

Result<detect::ModelSpec> spec_of_folder(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored))
    return fail(ErrorCode::kNotFound,
                "the embedder is neither an ONNX file nor a model folder: " + folder.string());
  auto spec = detect::load_model_spec(folder);
  if (!spec) return spec;
  if (spec->output.layout == detect::OutputLayout::kVector && spec->input.width == kAlignedSize &&
      spec->input.height == kAlignedSize)
    return spec;
  return fail(ErrorCode::kInvalidArgument,
              "model " + spec->name + " in " + folder.string() +
                  " cannot describe faces: it needs the layout vector and an input of 112 x 112 pixels");
}

}  // namespace

float similarity(const Feature& a, const Feature& b) {
  if (a.size() != b.size()) return 0.0F;
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0F);
}

Result<std::unique_ptr<FaceEmbedder>> make_network_embedder(const fs::path& path,
                                                            const detect::InferenceOptions& options) {
  std::error_code ignored;
  const auto spec = fs::is_regular_file(path, ignored) ? spec_of_file(path) : spec_of_folder(path);
  if (!spec) return tl::unexpected(spec.error());
  auto backend = detect::make_backend(*spec, options);
  if (!backend) return tl::unexpected(backend.error());
  const auto tried = (*backend)->infer(0);
  if (!tried) return tl::unexpected(tried.error());
  const std::size_t size = tried->front().size();
  return std::make_unique<NetworkEmbedder>(*spec, std::move(*backend), size);
}

}  // namespace extperfc::face
