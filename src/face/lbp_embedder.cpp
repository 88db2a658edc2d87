#include <cmath>

#include <opencv2/imgproc.hpp>

#include "extperfc/face/embedder.hpp"

#include "face/lbp.hpp"

namespace extperfc::face {

namespace {

constexpr int kCells = 7;  // along each axis: 15 or 16 pixels wide
// Two photographs, each rotated, dimmed and with noise: 0.77 to 0.95 with itself while the face is at least
// 90 pixels wide, 0.56 and more below; up to 0.72 with the other person. Between them, so that strangers stay
// unknown.
constexpr float kLbpThreshold = 0.8F;
constexpr float kLbpMargin = 0.03F;
constexpr double kSmoothingPx = 1.0;  // standard deviation: a camera's noise is no texture of a face

/// The square roots of the histograms, so that scalar products are Bhattacharyya coefficients.
class LbpEmbedder : public FaceEmbedder {
 public:
  std::string identity() const override { return "lbp 8,2 uniform 7x7"; }
  std::string execution() const override { return "local binary patterns"; }
  std::size_t size() const override { return static_cast<std::size_t>(kCells) * kCells * kLbpBins; }
  float default_threshold() const override { return kLbpThreshold; }
  float default_margin() const override { return kLbpMargin; }

  Result<Feature> embed(const AlignedFace& face) override {
    const ImageView view = face.view();
    const cv::Mat bgr(view.height, view.width, CV_8UC3, const_cast<std::uint8_t*>(view.data));
    cv::Mat1b grey;
    cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
    cv::GaussianBlur(grey, grey, {}, kSmoothingPx);
    Feature feature = lbp_histograms(lbp_bins(grey), kCells);
    for (float& value : feature) value = std::sqrt(value) / static_cast<float>(kCells);
    return feature;
  }
};

}  // namespace

std::unique_ptr<FaceEmbedder> make_lbp_embedder() {
  return std::make_unique<LbpEmbedder>();
}

}  // namespace extperfc::face
