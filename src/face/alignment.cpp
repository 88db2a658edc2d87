#include "extperfc/face/alignment.hpp"

#include <complex>

#include <opencv2/imgproc.hpp>

#include "detect/image_format.hpp"

namespace extperfc::face {

namespace {

using Complex = std::complex<double>;

/// Landmarks as numbers of the complex plane, in which a product rotates and scales.
std::array<Complex, 5> complex_of(const Landmarks& points) {
  std::array<Complex, 5> numbers;
  for (std::size_t i = 0; i < points.size(); ++i) numbers[i] = {points[i].x(), points[i].y()};
  return numbers;
}

Complex mean_of(const std::array<Complex, 5>& numbers) {
  Complex sum;
  for (const auto& number : numbers) sum += number;
  return sum / static_cast<double>(numbers.size());
}

AlignedFace cut_out(const cv::Mat& bgr, const Eigen::Affine2d& aligned_T_image) {
  const Eigen::Matrix<double, 2, 3, Eigen::RowMajor> rows = aligned_T_image.matrix().topRows<2>();
  const cv::Matx23d affine(rows.data());
  AlignedFace face;
  face.bgr.resize(static_cast<std::size_t>(kAlignedSize) * kAlignedSize * 3);
  cv::Mat pixels(kAlignedSize, kAlignedSize, CV_8UC3, face.bgr.data());
  cv::warpAffine(bgr, pixels, affine, pixels.size(), cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return face;
}

}  // namespace

const Landmarks& reference_landmarks() {
  static const Landmarks points{Eigen::Vector2f(38.2946F, 51.6963F), Eigen::Vector2f(73.5318F, 51.5014F),
                                Eigen::Vector2f(56.0252F, 71.7366F), Eigen::Vector2f(41.5493F, 92.3655F),
                                Eigen::Vector2f(70.7299F, 92.2041F)};
  return points;
}

ImageView AlignedFace::view() const {
  constexpr std::size_t kRowBytes = 3 * static_cast<std::size_t>(kAlignedSize);
  return {bgr.data(), kAlignedSize, kAlignedSize, kRowBytes, PixelFormat::kBgr8};
}

std::optional<Eigen::Affine2d> fit_similarity(const Landmarks& from, const Landmarks& to) {
  constexpr double kMinSpread = 1e-6;  // squared pixels
  const auto source = complex_of(from);
  const auto target = complex_of(to);
  const Complex source_mean = mean_of(source);
  const Complex target_mean = mean_of(target);
  Complex covariance;
  double spread = 0.0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    covariance += std::conj(source[i] - source_mean) * (target[i] - target_mean);
    spread += std::norm(source[i] - source_mean);
  }
  const Complex factor = covariance / spread;
  if (!(spread > kMinSpread) || !(std::norm(factor) > 0.0) || !std::isfinite(std::norm(factor)))
    return std::nullopt;
  const Complex offset = target_mean - factor * source_mean;
  Eigen::Affine2d to_T_from = Eigen::Affine2d::Identity();
  to_T_from.linear() << factor.real(), -factor.imag(), factor.imag(), factor.real();
  to_T_from.translation() << offset.real(), offset.imag();
  return to_T_from;
}

Result<std::vector<std::optional<AlignedFace>>> align(const ImageView& image,
                                                      const std::vector<Landmarks>& faces) try {
  const auto bgr = detect::bgr_image(image);
  if (!bgr) return tl::unexpected(bgr.error());
  std::vector<std::optional<AlignedFace>> aligned;
  for (const auto& landmarks : faces) {
    auto& face = aligned.emplace_back();
    if (const auto transform = fit_similarity(landmarks, reference_landmarks()))
      face = cut_out(*bgr, *transform);
  }
  return aligned;
} catch (const cv::Exception& error) {
  return fail(ErrorCode::kFailed, "cannot align a face: " + error.err);
}

}  // namespace extperfc::face
